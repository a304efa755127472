// The key of signatures is kept, and told to nobody but the lines.
#include <gtest/gtest.h>

#include <optional>

#include "memory.hpp"
#include "nonvolatile_sim.hpp"
#include "stator/testing.hpp"

namespace stator::drivers::nonvolatile {
namespace {

Memory* memory = nullptr;

using mav::SigningKey;

SigningKey key_of(uint8_t first) {
    SigningKey key{.state = SigningKey::State::kSet};
    for (uint8_t i = 0; i < mav::kKeyBytes; ++i) key.bytes[i] = static_cast<uint8_t>(first + i);
    return key;
}

// A life of the board, from a start to the loss of its power.
struct Life {
    explicit Life(Memory& bytes) {
        memory = &bytes;
        device.read = [](uint32_t address, std::span<uint8_t> data) {
            return MemoryPort{memory}.read(address, data);
        };
        device.write = [](uint32_t address, std::span<const uint8_t> data) {
            return memory->put(address, data);
        };
        device.key = &shared;
        driver.emplace(device);
    }
    void run(unsigned activations = 100) {
        for (unsigned i = 0; i < activations; ++i) {
            NonvolatilePorts ports{.now = now_us};
            stator::testing::Probe stored(ports.stored, ports.now);
            driver->step(ports);
            published += stored.count();
            now_us += 10'000;
        }
    }
    SigningKey key() const {
        SigningKey found;
        uint32_t version = 0;
        EXPECT_TRUE(shared.read(version, found));
        return found;
    }
    void change(const SigningKey& to) { EXPECT_TRUE(shared.write(to)); }

    mav::SharedKey shared;
    sim::NonvolatileSim::Device device;
    std::optional<sim::NonvolatileSim> driver;
    uint64_t now_us = 1000;
    uint32_t published = 0;
};

bool is_same(const SigningKey& a, const SigningKey& b) {
    return a.state == b.state && a.bytes == b.bytes;
}

TEST(Key, nothing_is_known_until_all_is_loaded) {
    Memory bytes;
    Life life(bytes);
    life.run(1);
    EXPECT_FALSE(life.shared.is_known());
    life.run();
    EXPECT_TRUE(life.shared.is_known());
    EXPECT_EQ(life.key().state, SigningKey::State::kNone);
}

TEST(Key, outlives_a_restart_and_is_published_nowhere) {
    Memory bytes;
    for (uint8_t i = 1; i < 5; ++i) {
        Life life(bytes);
        life.run();
        life.change(key_of(i));
        life.run();
        Life next(bytes);
        next.run();
        EXPECT_TRUE(is_same(next.key(), key_of(i))) << int{i};
        EXPECT_EQ(next.published, 0U);
    }
}

TEST(Key, an_old_one_is_not_in_the_memory_any_more) {
    Memory bytes;
    Life life(bytes);
    life.run();
    const auto has = [&](uint8_t first) {
        const SigningKey key = key_of(first);
        const auto wanted = std::span(key.bytes).first(16);
        return !std::ranges::search(bytes.bytes, wanted).empty();
    };
    life.change(key_of(50));
    life.run();
    EXPECT_TRUE(has(50));
    life.change(key_of(90));
    life.run();
    EXPECT_FALSE(has(50));
    EXPECT_TRUE(has(90));
    life.change({});
    life.run();
    EXPECT_FALSE(has(90));
    Life next(bytes);
    next.run();
    EXPECT_EQ(next.key().state, SigningKey::State::kNone);
}

// From one key to another, to none and from none: after any byte, the key is the old or the new
// one.
TEST(Key, a_power_cut_leaves_the_old_one_or_the_new_one) {
    const SigningKey none;
    for (const auto& [from, to] : {std::pair(key_of(1), key_of(40)), std::pair(key_of(1), none),
                                   std::pair(none, key_of(40))}) {
        Memory before;
        Life first(before);
        first.run();
        first.change(from);
        first.run(700);  // long enough for this start to count as one
        Memory whole = before;
        Life change(whole);
        change.run();
        whole.written = 0;
        change.change(to);
        change.run(20);
        const uint64_t most = whole.written;
        EXPECT_GT(most, 100U);
        unsigned old = 0;
        for (uint64_t cut = 0; cut <= most; cut += 3) {
            Memory bytes = before;
            Life life(bytes);
            life.run();
            bytes.written = 0;
            bytes.cut_after = cut;
            bytes.spoils_last = true;
            life.change(to);
            life.run(20);
            bytes.cut_after = Memory::kNoCut;
            Life next(bytes);
            next.run();
            const bool is_old = is_same(next.key(), from);
            EXPECT_TRUE(is_old || is_same(next.key(), to)) << cut << " of " << most;
            old += is_old ? 1 : 0;
        }
        EXPECT_GT(old, 10U);
        EXPECT_LT(old, most / 3);
    }
}

TEST(Key, whose_records_are_damaged_is_lost_and_not_none) {
    Memory bytes;
    Life life(bytes);
    life.run();
    life.change(key_of(9));
    life.run();
    for (std::size_t i = 0; i + 16 < bytes.bytes.size(); ++i) {
        if (bytes.bytes[i] == 9 && bytes.bytes[i + 1] == 10) bytes.bytes[i] = 0;
    }
    Life next(bytes);
    next.run();
    EXPECT_EQ(next.key().state, SigningKey::State::kLost);
}

TEST(Key, that_was_given_at_the_start_counts_and_is_not_kept) {
    Memory bytes;
    Life life(bytes);
    life.run();
    life.change(key_of(1));
    life.run();
    Life given(bytes);
    given.change(key_of(70));
    given.run();
    EXPECT_TRUE(is_same(given.key(), key_of(70)));
    Life next(bytes);
    next.run();
    EXPECT_TRUE(is_same(next.key(), key_of(1)));
}

TEST(Key, no_node_writes_one) {
    Memory bytes;
    Life life(bytes);
    life.run();
    StoredRecord record{.key = 0, .kind = StoredRecord::Kind::kSigningKey, .length = 9};
    NonvolatilePorts ports{.now = life.now_us, .store = Input(record)};
    stator::testing::Probe kept(ports.kept, ports.now);
    life.driver->step(ports);
    ASSERT_EQ(kept.count(), 1U);
    EXPECT_EQ(kept.newest().result, RecordKept::Result::kFailed);
    EXPECT_EQ(life.key().state, SigningKey::State::kNone);
}

TEST(Key, of_a_memory_that_fails_is_none) {
    Memory bytes;
    bytes.answers = false;
    Life life(bytes);
    life.run();
    EXPECT_TRUE(life.shared.is_known());
    EXPECT_EQ(life.key().state, SigningKey::State::kNone);
}

}  // namespace
}  // namespace stator::drivers::nonvolatile
