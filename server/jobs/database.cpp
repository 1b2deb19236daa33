// Database: SQLite as the job store uses it.
#include "server/jobs/database.h"

#include <sqlite3.h>

namespace alder::jobs {
namespace {

[[noreturn]] void refuse(sqlite3* db, int code) {
    const int primary = code & 0xFF;
    throw DatabaseError(db ? sqlite3_errmsg(db) : sqlite3_errstr(code), primary == SQLITE_FULL || primary == SQLITE_IOERR);
}

}  // namespace

Statement::~Statement() {
    sqlite3_reset(s_);
    sqlite3_clear_bindings(s_);
}

Statement& Statement::bind(int64_t value) {
    if (const int code = sqlite3_bind_int64(s_, next_++, value)) refuse(db_, code);
    return *this;
}
Statement& Statement::bind(double value) {
    if (const int code = sqlite3_bind_double(s_, next_++, value)) refuse(db_, code);
    return *this;
}
Statement& Statement::bind(std::string_view value) {
    const int code = sqlite3_bind_text64(s_, next_++, value.data() ? value.data() : "", value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
    if (code) refuse(db_, code);
    return *this;
}

bool Statement::step() {
    const int code = sqlite3_step(s_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) refuse(db_, code);
    return false;
}

int64_t Statement::integer(int column) const { return sqlite3_column_int64(s_, column); }
double Statement::real(int column) const { return sqlite3_column_double(s_, column); }
std::string Statement::text(int column) const {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(s_, column));
    return bytes ? std::string(bytes, static_cast<size_t>(sqlite3_column_bytes(s_, column))) : std::string();
}

Database::~Database() {
    for (const auto& [sql, statement] : prepared_) sqlite3_finalize(statement);
    sqlite3_close(db_);
}

void Database::open(const std::string& path, bool read_only) {
    const int flags = (read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE) | SQLITE_OPEN_NOMUTEX;
    if (const int code = sqlite3_open_v2(path.c_str(), &db_, flags, nullptr)) refuse(db_, code);
    sqlite3_extended_result_codes(db_, 1);
    sqlite3_busy_timeout(db_, 5000);
    if (read_only) return;
    execute("PRAGMA journal_mode=WAL");
    execute("PRAGMA synchronous=FULL");
    execute("PRAGMA foreign_keys=ON");
}

Statement Database::prepare(const char* sql) {
    sqlite3_stmt*& statement = prepared_[sql];
    if (!statement)
        if (const int code = sqlite3_prepare_v3(db_, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr)) refuse(db_, code);
    return Statement(db_, statement);
}

void Database::execute(const std::string& sql) {
    if (const int code = sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr)) refuse(db_, code);
}

int64_t Database::changes() const { return sqlite3_changes64(db_); }

Transaction::Transaction(Database& db) : db_(db) { db_.execute("BEGIN IMMEDIATE"); }
Transaction::~Transaction() {
    if (!open_) return;
    try {
        db_.execute("ROLLBACK");
    } catch (const DatabaseError&) {   // a full disk may have rolled it back already
    }
}
void Transaction::commit() {
    db_.execute("COMMIT");
    open_ = false;
}

}  // namespace alder::jobs
