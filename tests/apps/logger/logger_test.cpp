// The definitions at the beginning of a log: a bounded piece of them in each activation.
#include "logger.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "stator/testing.hpp"

namespace stator::apps::logger {
namespace {

using stator::testing::Probe;

constexpr size_t kTopics = 3;
constexpr size_t kParameters = 60;
constexpr size_t kFileHead = 16;

// A table whose formats are longer than a block, and of a log that needs little.
class LoggerTest : public ::testing::Test {
  protected:
    LoggerTest() {
        for (size_t i = 0; i < kTopics; ++i) {
            names_[i] = "topic" + std::to_string(i);
            formats_[i] = std::string(2500, static_cast<char>('a' + i));
            topics_[i].name = names_[i];
            topics_[i].format = formats_[i];
            topics_[i].topic = &logged_[i].topic();
            topics_[i].cursor = &cursors_[i];
        }
        for (size_t i = 0; i < kParameters; ++i) {
            parameter_names_[i] = "node.parameter_" + std::to_string(i);
            parameters_[i] = {parameter_names_[i], false, static_cast<ParameterBits>(i)};
        }
    }

    // One activation; returns the blocks that it published, and adds what they hold to the log.
    unsigned step() {
        LoggerPorts ports;
        ports.now = now_us_ += 5'000;
        ports.log = &table_;
        Probe<LogBlock> probe(ports.block, ports.now);
        logger_.step(ports);
        EXPECT_LE(probe.count(), 1U) << "definitions leave a block to samples";
        if (probe.count() == 0) return 0;
        const LogBlock& block = probe.newest();
        log_.insert(log_.end(), block.data.begin(), block.data.begin() + block.length);
        return 1;
    }

    // Messages of the log, by type: what each holds.
    std::map<char, std::vector<std::string>> messages() const {
        std::map<char, std::vector<std::string>> found;
        for (size_t at = kFileHead; at + 3 <= log_.size();) {
            const size_t size = log_[at] + size_t{256} * log_[at + 1];
            if (at + 3 + size > log_.size()) break;
            const char* content = reinterpret_cast<const char*>(log_.data()) + at + 3;
            found[static_cast<char>(log_[at + 2])].emplace_back(content, size);
            at += 3 + size;
        }
        return found;
    }

    std::array<std::string, kTopics> names_;
    std::array<std::string, kTopics> formats_;
    std::array<std::string, kParameters> parameter_names_;
    std::array<stator::testing::LoneTopic<LogBlock>, kTopics> logged_;
    std::array<LogCursor, kTopics> cursors_;
    std::array<LogTopic, kTopics> topics_{};
    std::array<LogParameter, kParameters> parameters_{};
    LogEvents events_;
    LogTable table_{.topics = topics_.data(),
                    .topic_count = kTopics,
                    .parameters = parameters_.data(),
                    .parameter_count = kParameters,
                    .blocks_at_once = 2,
                    .events = &events_,
                    .graph = "test",
                    .graph_hash = "0123"};
    Logger logger_;
    uint64_t now_us_ = 0;
    std::vector<uint8_t> log_;
};

TEST_F(LoggerTest, an_activation_writes_a_block_of_definitions_and_all_are_written) {
    for (unsigned i = 0; i < 50; ++i) step();
    const auto found = messages();
    ASSERT_EQ(found.at('F').size(), kTopics);
    for (size_t i = 0; i < kTopics; ++i) {
        EXPECT_EQ(found.at('F')[i], names_[i] + ":" + formats_[i]);
    }
    EXPECT_EQ(found.at('P').size(), kParameters);
    EXPECT_EQ(found.at('A').size(), kTopics);
}

TEST_F(LoggerTest, samples_come_after_the_definitions_and_those_before_are_not_lost) {
    const auto publish = [this](uint32_t length) {
        Output<LogBlock> output;
        output.connect(logged_[0].topic(), now_us_, false);
        output.publish([length] { return LogBlock{.length = length, .data = {}}; });
    };
    topics_[0].bytes = 12;
    for (uint32_t i = 1; i <= 60; ++i) {
        publish(i);
        step();
    }
    const auto found = messages();
    ASSERT_NE(found.find('D'), found.end());
    const auto& samples = found.at('D');
    EXPECT_LT(samples.size(), 60U);
    EXPECT_GT(samples.size(), 20U);
    EXPECT_EQ(cursors_[0].lost, 0U);
    EXPECT_EQ(found.find('O'), found.end()) << "a dropout";
}

}  // namespace
}  // namespace stator::apps::logger
