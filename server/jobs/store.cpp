// The job store: renders, their results and idempotency keys in SQLite.
#include "server/jobs/store.h"

#include <fmt/format.h>

namespace alder::jobs {
namespace {

// One entry a version of the schema: what leads to it from the one before. Entries are never edited, only appended.
constexpr const char* kMigrations[] = {
    R"(CREATE TABLE renders(
        id TEXT PRIMARY KEY, user TEXT NOT NULL, state TEXT NOT NULL, reason TEXT NOT NULL, version INTEGER NOT NULL,
        attempt INTEGER NOT NULL, crashes INTEGER NOT NULL, priority INTEGER NOT NULL,
        created REAL NOT NULL, started REAL NOT NULL, ended REAL NOT NULL, retain REAL NOT NULL, expired INTEGER NOT NULL,
        scene TEXT NOT NULL, scene_etag TEXT NOT NULL, snapshot TEXT NOT NULL, cache_key TEXT NOT NULL,
        request TEXT NOT NULL, labels TEXT NOT NULL, progress TEXT NOT NULL, timings TEXT NOT NULL, warnings TEXT NOT NULL,
        problem TEXT NOT NULL, stats TEXT NOT NULL) WITHOUT ROWID;
      CREATE INDEX renders_by_state ON renders(state, priority DESC, id);
      CREATE INDEX renders_by_result ON renders(cache_key) WHERE cache_key <> '';
      CREATE INDEX renders_by_end ON renders(ended) WHERE ended > 0 AND expired = 0;
      CREATE TABLE outputs(render TEXT NOT NULL REFERENCES renders(id) ON DELETE CASCADE, file TEXT NOT NULL, frame INTEGER NOT NULL,
        bytes INTEGER NOT NULL, digest TEXT NOT NULL, layers TEXT NOT NULL, complete INTEGER NOT NULL, PRIMARY KEY(render, file)) WITHOUT ROWID;
      CREATE TABLE labels(render TEXT NOT NULL REFERENCES renders(id) ON DELETE CASCADE, name TEXT NOT NULL, value TEXT NOT NULL,
        PRIMARY KEY(name, value, render)) WITHOUT ROWID;
      CREATE INDEX labels_by_render ON labels(render);
      CREATE TABLE assets(render TEXT NOT NULL REFERENCES renders(id) ON DELETE CASCADE, digest TEXT NOT NULL, PRIMARY KEY(digest, render)) WITHOUT ROWID;
      CREATE INDEX assets_by_render ON assets(render);
      CREATE TABLE answers(user TEXT NOT NULL, key TEXT NOT NULL, request TEXT NOT NULL, status INTEGER NOT NULL, body TEXT NOT NULL,
        render TEXT NOT NULL, created REAL NOT NULL, PRIMARY KEY(user, key)) WITHOUT ROWID;)",
};
constexpr int kSchemaVersion = std::size(kMigrations);

#define ALDER_JOB_COLUMNS                                                                                                             \
    "id, user, state, reason, version, attempt, crashes, priority, created, started, ended, retain, expired, scene, scene_etag, " \
    "snapshot, cache_key, request, labels, progress, timings, warnings, problem, stats"

nlohmann::json parsed(const std::string& text) { return nlohmann::json::parse(text, nullptr, false); }
std::string dumped(const nlohmann::json& j) { return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace); }

void insert_labels(Database& db, const Job& job) {
    for (const auto& [name, value] : job.labels.items())
        db.prepare("INSERT OR IGNORE INTO labels VALUES(?, ?, ?)").bind(job.id).bind(name).bind(value.get<std::string>()).run();
}

}  // namespace

std::string JobStore::open(const std::string& folder) {
    try {
        writer_.open(folder + "/jobs.db", false);
        migrate();
        reader_.open(folder + "/jobs.db", true);
    } catch (const DatabaseError& e) {
        return fmt::format("the job store {}/jobs.db cannot be used: {}", folder, e.what());
    }
    return {};
}

void JobStore::migrate() {
    Transaction t(writer_);
    int64_t version = 0;
    {
        Statement s = writer_.prepare("PRAGMA user_version");
        if (s.step()) version = s.integer(0);
    }
    if (version > kSchemaVersion)
        throw DatabaseError(fmt::format("it was written by a newer alderd (schema {}, known is {})", version, kSchemaVersion), false);
    for (; version < kSchemaVersion; ++version) writer_.execute(kMigrations[version]);
    writer_.execute(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
    t.commit();
}

void JobStore::insert(const Job& j, const std::vector<std::string>& assets, const Remembered* answer) {
    const std::lock_guard lock(write_mutex_);
    Transaction t(writer_);
    writer_.prepare("INSERT INTO renders(" ALDER_JOB_COLUMNS ") VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)")
        .bind(j.id).bind(j.user).bind(state_name(j.state)).bind(j.reason).bind(j.version).bind(int64_t{j.attempt}).bind(int64_t{j.crashes})
        .bind(j.priority).bind(j.created).bind(j.started).bind(j.ended).bind(j.retain).bind(int64_t{j.expired}).bind(j.scene).bind(j.scene_etag)
        .bind(j.snapshot).bind(j.cache_key).bind(dumped(j.request)).bind(dumped(j.labels)).bind(dumped(j.progress)).bind(dumped(j.timings))
        .bind(dumped(j.warnings)).bind(dumped(j.problem)).bind(dumped(j.stats)).run();
    insert_labels(writer_, j);
    for (const std::string& digest : assets) writer_.prepare("INSERT OR IGNORE INTO assets(render, digest) VALUES(?, ?)").bind(j.id).bind(digest).run();
    for (const Output& o : j.outputs)
        writer_.prepare("INSERT OR REPLACE INTO outputs VALUES(?,?,?,?,?,?,?)").bind(j.id).bind(o.file).bind(int64_t{o.frame})
            .bind(static_cast<int64_t>(o.bytes)).bind(o.digest).bind(dumped(o.layers)).bind(int64_t{o.complete}).run();
    if (answer)
        writer_.prepare("INSERT OR REPLACE INTO answers VALUES(?,?,?,?,?,?,?)").bind(answer->user).bind(answer->key).bind(answer->request_digest)
            .bind(int64_t{answer->status}).bind(answer->body).bind(answer->render).bind(wall_seconds()).run();
    t.commit();
}

void JobStore::update(Job& j) {
    const std::lock_guard lock(write_mutex_);
    Transaction t(writer_);
    writer_.prepare("UPDATE renders SET state=?, reason=?, version=?, attempt=?, crashes=?, priority=?, started=?, ended=?, retain=?, expired=?, "
                    "cache_key=?, request=?, labels=?, progress=?, timings=?, warnings=?, problem=?, stats=? WHERE id=?")
        .bind(state_name(j.state)).bind(j.reason).bind(j.version + 1).bind(int64_t{j.attempt}).bind(int64_t{j.crashes}).bind(j.priority)
        .bind(j.started).bind(j.ended).bind(j.retain).bind(int64_t{j.expired}).bind(j.cache_key).bind(dumped(j.request)).bind(dumped(j.labels))
        .bind(dumped(j.progress)).bind(dumped(j.timings)).bind(dumped(j.warnings)).bind(dumped(j.problem)).bind(dumped(j.stats)).bind(j.id).run();
    writer_.prepare("DELETE FROM labels WHERE render=?").bind(j.id).run();
    insert_labels(writer_, j);
    if (j.expired) {
        writer_.prepare("DELETE FROM outputs WHERE render=?").bind(j.id).run();
        writer_.prepare("DELETE FROM assets WHERE render=?").bind(j.id).run();
    }
    t.commit();
    ++j.version;
    j.live_tag.clear();
}

void JobStore::add_output(const std::string& id, const Output& o) {
    const std::lock_guard lock(write_mutex_);
    writer_.prepare("INSERT OR REPLACE INTO outputs VALUES(?,?,?,?,?,?,?)").bind(id).bind(o.file).bind(int64_t{o.frame}).bind(static_cast<int64_t>(o.bytes))
        .bind(o.digest).bind(dumped(o.layers)).bind(int64_t{o.complete}).run();
}

void JobStore::clear_outputs(const std::string& id) {
    const std::lock_guard lock(write_mutex_);
    writer_.prepare("DELETE FROM outputs WHERE render=?").bind(id).run();
}

bool JobStore::remove(const std::string& id) {
    const std::lock_guard lock(write_mutex_);
    writer_.prepare("DELETE FROM renders WHERE id=?").bind(id).run();
    return writer_.changes() > 0;
}

Job JobStore::row(Statement& s) {
    Job j;
    int c = 0;
    j.id = s.text(c++);
    j.user = s.text(c++);
    state_from_name(s.text(c++), j.state);
    j.reason = s.text(c++);
    j.version = s.integer(c++);
    j.attempt = static_cast<int>(s.integer(c++));
    j.crashes = static_cast<int>(s.integer(c++));
    j.priority = s.integer(c++);
    j.created = s.real(c++);
    j.started = s.real(c++);
    j.ended = s.real(c++);
    j.retain = s.real(c++);
    j.expired = s.integer(c++) != 0;
    j.scene = s.text(c++);
    j.scene_etag = s.text(c++);
    j.snapshot = s.text(c++);
    j.cache_key = s.text(c++);
    for (nlohmann::json* member : {&j.request, &j.labels, &j.progress, &j.timings, &j.warnings, &j.problem, &j.stats}) *member = parsed(s.text(c++));
    return j;
}

void JobStore::load_outputs(Job& job) {
    Statement s = reader_.prepare("SELECT file, frame, bytes, digest, layers, complete FROM outputs WHERE render=? ORDER BY frame, file");
    s.bind(job.id);
    while (s.step())
        job.outputs.push_back({s.text(0), static_cast<int>(s.integer(1)), static_cast<uint64_t>(s.integer(2)), s.text(3),
                               parsed(s.text(4)).get<std::vector<std::string>>(), s.integer(5) != 0});
}

std::optional<Job> JobStore::get(const std::string& id) {
    const std::lock_guard lock(read_mutex_);
    std::optional<Job> job;
    {
        Statement s = reader_.prepare("SELECT " ALDER_JOB_COLUMNS " FROM renders WHERE id=?");
        s.bind(id);
        if (s.step()) job = row(s);
    }
    if (job) load_outputs(*job);
    return job;
}

bool JobStore::exists(const std::string& id) {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT 1 FROM renders WHERE id=?");
    return s.bind(id).step();
}

std::vector<Job> JobStore::list(const ListFilter& f) {
    const std::lock_guard lock(read_mutex_);
    std::vector<Job> jobs;
    {
        // '' stands for "any": no such state, scene or label is stored. Users may be '', so they have a flag.
        const auto select = [&](const char* sql, bool labelled) {
            Statement s = reader_.prepare(sql);
            if (labelled) s.bind(f.labels[0].first).bind(f.labels[0].second);
            const std::string state = f.state ? state_name(*f.state) : "", scene = f.scene.value_or("");
            s.bind(f.before.empty() ? std::string_view("~") : f.before).bind(state).bind(state).bind(scene).bind(scene)
                .bind(int64_t{!f.user}).bind(f.user.value_or(""));
            while (static_cast<int>(jobs.size()) < f.limit && s.step()) {
                Job job = row(s);
                bool fits = true;
                for (const auto& [name, value] : f.labels) fits = fits && job.labels.value(name, "") == value && job.labels.contains(name);
                if (fits) jobs.push_back(std::move(job));
            }
        };
        if (f.labels.empty())
            select("SELECT " ALDER_JOB_COLUMNS " FROM renders WHERE id<? AND (?='' OR state=?) AND (?='' OR scene=?) AND (? OR user=?) ORDER BY id DESC", false);
        else
            select("SELECT " ALDER_JOB_COLUMNS " FROM renders WHERE id IN (SELECT render FROM labels WHERE name=? AND value=?) AND id<? AND (?='' OR state=?) "
                   "AND (?='' OR scene=?) AND (? OR user=?) ORDER BY id DESC", true);
    }
    for (Job& job : jobs) load_outputs(job);
    return jobs;
}

int64_t JobStore::count(std::optional<State> state, const std::string* user) {
    const std::lock_guard lock(read_mutex_);
    Statement s = state ? reader_.prepare("SELECT COUNT(*) FROM renders WHERE state=? AND (? OR user=?)")
                        : reader_.prepare("SELECT COUNT(*) FROM renders WHERE state IN ('queued','preparing','rendering','writing','paused') AND (? OR user=?)");
    if (state) s.bind(state_name(*state));
    s.bind(int64_t{user == nullptr}).bind(user ? *user : std::string());
    return s.step() ? s.integer(0) : 0;
}

std::vector<std::pair<std::string, std::string>> JobStore::next_by_user() {
    const std::lock_guard lock(read_mutex_);
    std::vector<std::pair<std::string, std::string>> out;
    Statement s = reader_.prepare("SELECT user, MIN(id) FROM renders WHERE state='queued' AND priority=(SELECT priority FROM renders WHERE state='queued' "
                                  "ORDER BY priority DESC LIMIT 1) GROUP BY user");
    while (s.step()) out.emplace_back(s.text(0), s.text(1));
    return out;
}

std::vector<std::string> JobStore::ids_in(State state) {
    const std::lock_guard lock(read_mutex_);
    std::vector<std::string> ids;
    Statement s = reader_.prepare("SELECT id FROM renders WHERE state=? ORDER BY priority DESC, id");
    s.bind(state_name(state));
    while (s.step()) ids.push_back(s.text(0));
    return ids;
}

std::vector<std::string> JobStore::recover() {
    const std::lock_guard lock(write_mutex_);
    std::vector<std::string> ids;
    {
        Statement s = writer_.prepare("SELECT id FROM renders WHERE state IN ('preparing','rendering','writing')");
        while (s.step()) ids.push_back(s.text(0));
    }
    if (!ids.empty()) {
        Transaction t(writer_);
        writer_.execute("UPDATE renders SET state='queued', version=version+1 WHERE state IN ('preparing','rendering','writing')");
        t.commit();
    }
    return ids;
}

std::vector<std::string> JobStore::due(double now) {
    const std::lock_guard lock(read_mutex_);
    std::vector<std::string> ids;
    Statement s = reader_.prepare("SELECT id FROM renders WHERE ended>0 AND expired=0 AND ended+retain<? LIMIT 1000");
    s.bind(now);
    while (s.step()) ids.push_back(s.text(0));
    return ids;
}

std::optional<std::string> JobStore::find_result(const std::string& cache_key) {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT id FROM renders WHERE cache_key=? AND cache_key<>'' AND state='succeeded' AND expired=0 ORDER BY id DESC LIMIT 1");
    s.bind(cache_key);
    return s.step() ? std::optional(s.text(0)) : std::nullopt;
}

std::optional<Remembered> JobStore::remembered(const std::string& user, const std::string& key, double oldest) {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT request, status, body, render FROM answers WHERE user=? AND key=? AND created>=?");
    s.bind(user).bind(key).bind(oldest);
    if (!s.step()) return std::nullopt;
    return Remembered{user, key, s.text(0), static_cast<int>(s.integer(1)), s.text(2), s.text(3)};
}

void JobStore::forget(double oldest) {
    const std::lock_guard lock(write_mutex_);
    writer_.prepare("DELETE FROM answers WHERE created<?").bind(oldest).run();
}

std::string JobStore::user_of(const std::string& digest) {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT a.render FROM assets a JOIN renders r ON r.id=a.render WHERE a.digest=? AND r.ended=0 LIMIT 1");
    s.bind(digest);
    return s.step() ? s.text(0) : std::string();
}

bool JobStore::names(const std::string& digest) {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT 1 FROM assets WHERE digest=? LIMIT 1");
    s.bind(digest);
    return s.step();
}

uint64_t JobStore::output_bytes() {
    const std::lock_guard lock(read_mutex_);
    Statement s = reader_.prepare("SELECT COALESCE(SUM(bytes),0) FROM outputs");
    return s.step() ? static_cast<uint64_t>(s.integer(0)) : 0;
}

}  // namespace alder::jobs
