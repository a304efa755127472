// Logs are listed and downloaded as stations do it.
#include "log_transfer.hpp"

#include <map>
#include <string_view>

#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

class LogTransferTest : public MavlinkTest {
  protected:
    LogTransferTest() {
        std::vector<uint8_t> log;
        for (unsigned i = 0; i < 1000; ++i) log.push_back(static_cast<uint8_t>(i * 3));
        logs_ = {log, std::vector<uint8_t>(180, 9), std::vector<uint8_t>(45, 1)};
    }
    void list(uint16_t start = 0, uint16_t end = 0xFFFF) {
        send(mav::LogRequestList{
            .start = start, .end = end, .target_system = 1, .target_component = 1});
        run(2.0);
    }
    void download(uint16_t log, uint32_t offset, uint32_t count) {
        send(mav::LogRequestData{
            .ofs = offset, .count = count, .id = log, .target_system = 1, .target_component = 1});
        run(2.0);
    }
    std::vector<int> listed() {
        std::vector<int> ids;
        for (const auto& entry : heard<mav::LogEntry>()) {
            ids.push_back(entry.id);
            EXPECT_EQ(entry.num_logs, logs_.size());
            EXPECT_EQ(entry.last_log_num, logs_.size() - 1);
            EXPECT_EQ(entry.size, logs_.at(entry.id).size());
        }
        return ids;
    }
    // The counts of all messages; their bytes must be the log's.
    std::vector<int> counts(uint16_t log) {
        std::vector<int> all;
        for (const auto& message : heard<mav::LogData>()) {
            all.push_back(message.count);
            EXPECT_EQ(message.id, log);
            for (unsigned i = 0; i < message.count; ++i) {
                EXPECT_EQ(message.data[i], logs_.at(log).at(message.ofs + i));
            }
        }
        return all;
    }
    unsigned texts() { return static_cast<unsigned>(heard<mav::Statustext>().size()); }
};

TEST_F(LogTransferTest, ListsAllAndTheFirstOneTwice) {
    list();
    EXPECT_EQ(listed(), (std::vector{0, 1, 2, 0}));
    forget();
    list(1, 1);
    EXPECT_EQ(listed(), (std::vector{1, 1}));
    EXPECT_EQ(texts(), 0U);
}

TEST_F(LogTransferTest, WithoutLogsTheListIsEmpty) {
    logs_.clear();
    for (const bool reads : {true, false}) {  // no log, and no answer
        reads_logs_ = reads;
        forget();
        list();
        const auto entries = heard<mav::LogEntry>();
        ASSERT_EQ(entries.size(), 1U);
        EXPECT_EQ(entries[0].num_logs, 0);
        EXPECT_EQ(entries[0].id, 0);
        EXPECT_EQ(texts(), 1U) << "a person is told why";
    }
}

TEST_F(LogTransferTest, DownloadsToTheEnd) {
    download(0, 0, UINT32_MAX);
    std::vector<int> expected(11, 90);
    expected.push_back(10);
    EXPECT_EQ(counts(0), expected);
    forget();
    download(1, 0, UINT32_MAX);
    EXPECT_EQ(counts(1), (std::vector{90, 90, 0})) << "an empty one says that it ends";
    forget();
    download(1, 0, 180);
    EXPECT_EQ(counts(1), (std::vector{90, 90})) << "as many as were asked for";
    forget();
    download(2, 0, 46080);
    EXPECT_EQ(counts(2), (std::vector{45}));
}

TEST_F(LogTransferTest, AGapIsSentAgain) {
    download(0, 270, 180);
    EXPECT_EQ(counts(0), (std::vector{90, 90}));
    EXPECT_EQ(heard<mav::LogData>()[0].ofs, 270U);
    forget();
    download(0, 271, 100);
    EXPECT_EQ(counts(0), (std::vector{90, 10}));
}

TEST_F(LogTransferTest, BehindTheEndAndOfNoLogThereIsNothing) {
    download(0, 1000, 90);
    EXPECT_EQ(counts(0), (std::vector{0}));
    forget();
    download(0, UINT32_MAX, UINT32_MAX);
    EXPECT_EQ(counts(0), (std::vector{0}));
    forget();
    download(7, 0, 90);
    EXPECT_EQ(counts(7), (std::vector{0}));
    forget();
    download(0, 0, 0);
    EXPECT_EQ(counts(0), (std::vector<int>{}));
}

TEST_F(LogTransferTest, ALogThatGrowsHasAnEnd) {
    send(mav::LogRequestData{
        .ofs = 0, .count = UINT32_MAX, .id = 0, .target_system = 1, .target_component = 1});
    for (unsigned i = 0; i < 200; ++i) {
        logs_[0].insert(logs_[0].end(), 180, 5);
        step();
    }
    std::size_t sum = 0;
    for (const int count : counts(0)) sum += static_cast<std::size_t>(count);
    EXPECT_EQ(sum, 1180U) << "as long as it was at the first piece";
    EXPECT_EQ(heard<mav::LogData>().back().count, 1180 % 90);
}

TEST_F(LogTransferTest, EndsAtOnce) {
    logs_[0].assign(20'000, 1);
    send(mav::LogRequestData{
        .ofs = 0, .count = UINT32_MAX, .id = 0, .target_system = 1, .target_component = 1});
    run(0.2);
    send(mav::LogRequestEnd{.target_system = 1, .target_component = 1});
    run(0.05);
    forget();
    run(1.0);
    EXPECT_TRUE(heard<mav::LogData>().empty());
}

TEST_F(LogTransferTest, NothingIsErased) {
    send(mav::LogErase{.target_system = 1, .target_component = 1});
    run(0.1);
    EXPECT_EQ(texts(), 1U);
    list();
    EXPECT_EQ(listed(), (std::vector{0, 1, 2, 0}));
}

}  // namespace
}  // namespace stator::apps::mavlink
