// The driver of a nonvolatile memory: loads, tells, then keeps.
#include <gtest/gtest.h>

#include <optional>

#include "memory.hpp"
#include "nonvolatile_sim.hpp"
#include "stator/testing.hpp"

namespace stator::drivers::nonvolatile {
namespace {

Memory* memory = nullptr;

using State = NonvolatileStatus::State;

struct Driver : ::testing::Test {
    Driver() {
        memory = &own;
        device.read = [](uint32_t address, std::span<uint8_t> bytes) {
            return MemoryPort{memory}.read(address, bytes);
        };
        device.write = [](uint32_t address, std::span<const uint8_t> bytes) {
            return memory->put(address, bytes);
        };
    }
    // One activation. The newest of what it published, as a probe keeps no more.
    void step(const StoredRecord* record = nullptr) {
        NonvolatilePorts ports{.now = now_us,
                               .store = record == nullptr ? Input<StoredRecord>() : Input(*record)};
        stator::testing::Probe stored(ports.stored, ports.now);
        stator::testing::Probe told(ports.status, ports.now);
        stator::testing::Probe kept_record(ports.kept, ports.now);
        driver->step(ports);
        EXPECT_LE(stored.count(), 4U) << "the burst of the interface";
        if (stored.count() != 0) newest = stored.newest();
        loaded += stored.count();
        if (told.count() != 0) status = told.newest();
        was_told = told.count() != 0;
        EXPECT_EQ(kept_record.count(),
                  record != nullptr && status.state != State::kLoading ? 1U : 0U);
        if (kept_record.count() != 0) kept = kept_record.newest();
        now_us += 10'000;
    }
    void start() {
        for (int i = 0; i < 100; ++i) step();
    }

    Memory own;
    sim::NonvolatileSim::Device device;
    std::optional<sim::NonvolatileSim> driver{std::in_place, device};
    NonvolatileStatus status{};
    StoredRecord newest{};
    uint32_t loaded = 0;
    RecordKept kept{};
    uint64_t now_us = 1000;
    bool was_told = false;
};

TEST_F(Driver, an_empty_memory_is_loaded_in_65_activations) {
    for (int i = 0; i < 64; ++i) step();
    EXPECT_EQ(status.state, State::kLoading);
    step();
    EXPECT_EQ(status.state, State::kLoaded);
    EXPECT_EQ(status.records, 0);
    EXPECT_EQ(status.most_records, 255);
    step();
    EXPECT_FALSE(was_told) << "nothing new";
}

TEST_F(Driver, what_was_kept_comes_after_the_next_start) {
    start();
    const StoredRecord record = record_of(77, 7);
    step(&record);
    EXPECT_EQ(kept.result, RecordKept::Result::kKept);
    EXPECT_EQ(kept.key, 77U);
    EXPECT_EQ(status.records, 1);
    EXPECT_EQ(status.refused, 0U);
    driver.emplace(device);
    EXPECT_EQ(loaded, 0U);
    start();
    EXPECT_EQ(loaded, 1U);
    EXPECT_EQ(newest.key, 77U);
    EXPECT_EQ(newest.data, record.data);
}

TEST_F(Driver, nothing_is_taken_before_all_is_loaded) {
    const StoredRecord record = record_of(1, 1);
    step(&record);
    EXPECT_EQ(own.written, 64U) << "the count of starts";
}

TEST_F(Driver, a_memory_that_does_not_answer_fails_in_bounded_time) {
    own.answers = false;
    for (int i = 0; i < 5; ++i) step();
    EXPECT_EQ(status.state, State::kFailed);
    const StoredRecord record = record_of(1, 1);
    step(&record);
    EXPECT_EQ(status.refused, 1U);
}

TEST_F(Driver, a_board_without_a_memory_fails_the_same_way) {
    device = {};
    start();
    EXPECT_EQ(status.state, State::kFailed);
}

TEST_F(Driver, a_memory_that_comes_up_late_is_waited_for) {
    own.answers = false;
    for (int i = 0; i < 4; ++i) step();
    own.answers = true;
    start();
    EXPECT_EQ(status.state, State::kLoaded);
}

TEST_F(Driver, a_write_that_fails_is_counted) {
    start();
    own.answers = false;
    const StoredRecord record = record_of(1, 1);
    step(&record);
    EXPECT_EQ(status.refused, 1U);
    EXPECT_EQ(kept.result, RecordKept::Result::kFailed);
    EXPECT_EQ(status.state, State::kLoaded);
}

TEST_F(Driver, a_start_that_ended_soon_is_told_to_the_next_one) {
    for (uint8_t lives = 0; lives < 3; ++lives) {
        driver.emplace(device);
        start();  // for a second
        EXPECT_EQ(status.short_lives, lives);
    }
    for (int i = 0; i < 500; ++i) step();
    driver.emplace(device);
    start();
    EXPECT_EQ(status.short_lives, 0);
}

TEST_F(Driver, a_new_record_begins_the_count_of_starts_again) {
    start();
    const StoredRecord record = record_of(1, 1);
    step(&record);
    driver.emplace(device);
    start();
    EXPECT_EQ(status.short_lives, 0);
}

}  // namespace
}  // namespace stator::drivers::nonvolatile
