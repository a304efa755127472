// The newest value between two threads, and within one.
#include "stator/newest.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace stator {
namespace {

// Words that are alike, unless two values were mixed; of odd length, with padding.
struct Value {
    uint64_t first = 0;
    std::array<uint32_t, 12> middle{};
    uint8_t last = 0;
};

Value of(uint32_t number) {
    Value value{.first = number, .last = static_cast<uint8_t>(number)};
    value.middle.fill(number);
    return value;
}

bool is_whole(const Value& value) {
    for (const uint32_t word : value.middle) {
        if (word != value.first) return false;
    }
    return value.last == static_cast<uint8_t>(value.first);
}

TEST(Newest, is_the_default_before_the_first_one) {
    const Newest<Value> newest;
    EXPECT_EQ(newest.get().count, 0U);
    EXPECT_EQ(newest.get().value.first, 0U);
}

TEST(Newest, counts_its_values) {
    Newest<Value> newest;
    for (uint32_t i = 1; i <= 5; ++i) {
        newest.put(of(10 * i));
        const auto [value, count] = newest.get();
        EXPECT_EQ(count, i);
        EXPECT_EQ(value.first, 10 * i);
        EXPECT_TRUE(is_whole(value));
    }
}

TEST(Newest, is_whole_and_never_older_while_another_thread_writes) {
    constexpr uint32_t kValues = 300'000;
    Newest<Value> newest;
    std::thread writer([&] {
        for (uint32_t i = 1; i <= kValues; ++i) newest.put(of(i));
    });
    uint32_t broken = 0;
    for (uint32_t count = 0; count < kValues;) {
        const auto read = newest.get();
        if (read.count < count || read.value.first != read.count || !is_whole(read.value)) ++broken;
        count = read.count;
    }
    writer.join();
    EXPECT_EQ(broken, 0U);
}

}  // namespace
}  // namespace stator
