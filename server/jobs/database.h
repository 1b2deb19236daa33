// Database: SQLite as the job store uses it: one writer and one reader on the same file, prepared statements, transactions.
//
// WAL lets the reader go on while the writer waits for the disk; synchronous=FULL makes a commit durable before it returns.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>

struct sqlite3;
struct sqlite3_stmt;

namespace alder::jobs {

/// What SQLite refuses. `full`: for want of space, which may come back.
struct DatabaseError : std::runtime_error {
    DatabaseError(const std::string& what, bool is_full) : std::runtime_error(what), full(is_full) {}
    bool full;
};

/// One use of a prepared statement: bound in order, stepped, reset when it goes.
class Statement {
  public:
    explicit Statement(sqlite3* db, sqlite3_stmt* statement) : db_(db), s_(statement) {}
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int64_t value);
    Statement& bind(double value);
    Statement& bind(std::string_view value);
    /// True while there is a row.
    bool step();
    void run() {
        while (step()) {}
    }
    int64_t integer(int column) const;
    double real(int column) const;
    std::string text(int column) const;

  private:
    sqlite3* db_;
    sqlite3_stmt* s_;
    int next_ = 1;
};

class Database {
  public:
    Database() = default;
    ~Database();
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// Opens or makes the file. Throws DatabaseError.
    void open(const std::string& path, bool read_only);
    Statement prepare(const char* sql);   ///< `sql` must be a literal: prepared once
    void execute(const std::string& sql);
    int64_t changes() const;

  private:
    sqlite3* db_ = nullptr;
    std::unordered_map<const char*, sqlite3_stmt*> prepared_;
};

/// Rolled back unless committed.
class Transaction {
  public:
    explicit Transaction(Database& db);
    ~Transaction();
    void commit();

  private:
    Database& db_;
    bool open_ = true;
};

}  // namespace alder::jobs
