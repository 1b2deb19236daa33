// The job store: what is stored comes back, in order, and only what belongs together is kept together.
#include "server/jobs/store.h"

#include <filesystem>

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

namespace alder::jobs {
namespace {

class JobStoreTest : public ::testing::Test {
  protected:
    std::string folder = ::testing::TempDir() + "alder_store_" + std::to_string(getpid());
    JobStoreTest() { std::filesystem::create_directories(folder); }
    ~JobStoreTest() override { std::filesystem::remove_all(folder); }

    static std::string id_of(int number) {
        char text[32];
        snprintf(text, sizeof text, "rnd_%026d", number);
        return text;
    }
    static Job job(int number, int64_t priority = 50, const std::string& user = "", State state = State::Queued) {
        Job j;
        j.id = id_of(number);
        j.user = user;
        j.state = state;
        j.priority = priority;
        j.created = 1000 + number;
        j.retain = 100;
        j.scene = "scn_x";
        j.snapshot = "sha256:s";
        j.request = {{"scene", "scn_x"}, {"samples", number}};
        j.labels = {{"shot", number % 2 ? "odd" : "even"}};
        return j;
    }
};

TEST_F(JobStoreTest, a_job_survives_its_process) {
    Job j = job(1);
    {
        JobStore store;
        ASSERT_EQ(store.open(folder), "");
        store.insert(j, {"sha256:a"}, nullptr);
        store.add_output(j.id, {"b.exr", 2, 20, "sha256:b", {"rgba", "P"}, true});
        store.add_output(j.id, {"a.exr", 1, 10, "sha256:a", {"rgba"}, false});
        j.state = State::Paused;
        j.reason = "disk-full";
        j.progress = {{"fraction", 0.5}};
        store.update(j);
        EXPECT_EQ(j.version, 2);
    }
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    const auto back = store.get(j.id);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->state, State::Paused);
    EXPECT_EQ(back->reason, "disk-full");
    EXPECT_EQ(back->request["samples"], 1);
    EXPECT_EQ(back->progress["fraction"], 0.5);
    EXPECT_EQ(back->etag(), "\"2\"");
    ASSERT_EQ(back->outputs.size(), 2u);
    EXPECT_EQ(back->outputs[0].file, "a.exr");
    EXPECT_FALSE(back->outputs[0].complete);
    EXPECT_EQ(back->outputs[1].layers, (std::vector<std::string>{"rgba", "P"}));
    EXPECT_EQ(store.user_of("sha256:a"), j.id);
    EXPECT_TRUE(store.remove(j.id));
    EXPECT_FALSE(store.get(j.id));
    EXPECT_EQ(store.user_of("sha256:a"), "");
    EXPECT_EQ(store.output_bytes(), 0u);
}

TEST_F(JobStoreTest, what_was_in_hand_is_queued_again) {
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    int n = 0;
    for (const State s : {State::Preparing, State::Rendering, State::Writing, State::Paused, State::Succeeded, State::Cancelled}) store.insert(job(++n, 50, "", s), {}, nullptr);
    EXPECT_EQ(store.recover().size(), 3u);
    EXPECT_EQ(store.count(State::Queued), 3);
    EXPECT_EQ(store.count(State::Paused), 1);
    EXPECT_EQ(store.count(std::nullopt), 4);
    EXPECT_TRUE(store.recover().empty());
}

TEST_F(JobStoreTest, the_next_is_the_oldest_of_the_highest_priority_of_each_user) {
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    store.insert(job(1, 10, "ann"), {}, nullptr);
    store.insert(job(2, 60, "ann"), {}, nullptr);
    store.insert(job(3, 60, "bob"), {}, nullptr);
    store.insert(job(4, 60, "ann"), {}, nullptr);
    store.insert(job(5, 90, "cleo", State::Paused), {}, nullptr);
    const std::vector<std::pair<std::string, std::string>> expected{{"ann", id_of(2)}, {"bob", id_of(3)}};
    EXPECT_EQ(store.next_by_user(), expected);
}

TEST_F(JobStoreTest, lists_newest_first_by_filters_and_cursor) {
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    for (int i = 1; i <= 9; ++i) store.insert(job(i, 50, i <= 3 ? "ann" : "", i == 5 ? State::Failed : State::Queued), {}, nullptr);
    const auto numbers = [&](const ListFilter& f) {
        std::vector<int> out;
        for (const Job& j : store.list(f)) out.push_back(j.request["samples"]);
        return out;
    };
    ListFilter f;
    f.limit = 3;
    EXPECT_EQ(numbers(f), (std::vector<int>{9, 8, 7}));
    f.before = id_of(7);
    EXPECT_EQ(numbers(f), (std::vector<int>{6, 5, 4}));
    f = {};
    f.labels = {{"shot", "odd"}};
    EXPECT_EQ(numbers(f), (std::vector<int>{9, 7, 5, 3, 1}));
    f.state = State::Failed;
    EXPECT_EQ(numbers(f), (std::vector<int>{5}));
    f = {};
    f.user = "ann";
    EXPECT_EQ(numbers(f), (std::vector<int>{3, 2, 1}));
    f.user = "";
    EXPECT_EQ(numbers(f).size(), 6u);
    f = {};
    f.scene = "scn_y";
    EXPECT_TRUE(numbers(f).empty());
}

TEST_F(JobStoreTest, answers_are_kept_with_the_job_or_not_at_all) {
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    const Remembered answer{"ann", "key", "digest", 202, "{}", id_of(1)};
    store.insert(job(1), {}, &answer);
    EXPECT_THROW(store.insert(job(1), {}, nullptr), DatabaseError) << "an id is there once";
    const Remembered second{"ann", "other", "digest", 202, "{}", id_of(1)};
    EXPECT_THROW(store.insert(job(1), {}, &second), DatabaseError);
    EXPECT_FALSE(store.remembered("ann", "other", 0));
    const auto back = store.remembered("ann", "key", 0);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->render, id_of(1));
    EXPECT_FALSE(store.remembered("bob", "key", 0));
    EXPECT_FALSE(store.remembered("ann", "key", wall_seconds() + 10));
    store.forget(wall_seconds() + 10);
    EXPECT_FALSE(store.remembered("ann", "key", 0));
}

TEST_F(JobStoreTest, results_by_content_and_retention) {
    JobStore store;
    ASSERT_EQ(store.open(folder), "");
    Job j = job(1, 50, "", State::Succeeded);
    j.cache_key = "k";
    j.ended = 1000;
    store.insert(j, {"sha256:a"}, nullptr);
    EXPECT_EQ(store.find_result("k"), j.id);
    EXPECT_FALSE(store.find_result(""));
    EXPECT_EQ(store.user_of("sha256:a"), "") << "a finished render does not hold on to assets ...";
    EXPECT_TRUE(store.names("sha256:a")) << "... but they are not rubbish yet";
    EXPECT_TRUE(store.due(1099).empty());
    EXPECT_EQ(store.due(1101).size(), 1u);
    j.expired = true;
    store.update(j);
    EXPECT_FALSE(store.find_result("k"));
    EXPECT_TRUE(store.due(1101).empty());
    EXPECT_FALSE(store.names("sha256:a"));
}

TEST_F(JobStoreTest, a_newer_schema_is_refused) {
    {
        JobStore store;
        ASSERT_EQ(store.open(folder), "");
    }
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((folder + "/jobs.db").c_str(), &db), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(db, "PRAGMA user_version = 1000", nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(db);
    JobStore store;
    EXPECT_NE(store.open(folder).find("newer"), std::string::npos);
}

}  // namespace
}  // namespace alder::jobs
