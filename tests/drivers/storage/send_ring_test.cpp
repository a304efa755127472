// A line that only sends, on the model of the chip: what goes in comes out, in order, or is
// refused.
#include "stm32f4/send_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "chip/usart.hpp"
#include "mapped_ram.hpp"
#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"

namespace stator::stm32f4 {
namespace {

struct Bytes {
    static constexpr size_t size() { return 64; }
    static inline uint8_t* const bytes = chip::MappedRam::bytes();
};
constexpr uint32_t kUart7 = 0x40007800;
constexpr unsigned kEnd = 12;  // DMA1 stream 1

class Ring : public ::testing::Test {
  public:
    Ring() {
        current_chip = &chip_;
        EXPECT_EQ(start_clocks(24), ClockSource::kCrystal);
        rcc::kApb1Enable.set(1U << 30);
        chip_.usart("UART7").watch([this](uint8_t byte) { sent.push_back(byte); });
        ring.start();
    }
    ~Ring() override { current_chip = nullptr; }

    void run_us(uint64_t us) {
        const uint64_t end_ns = chip_.now_ns() + us * 1000;
        while (chip_.now_ns() < end_ns) {
            chip_.move(std::min(chip_.visible_ns(), end_ns));
            if ((chip_.levels()[0] >> kEnd & 1) != 0) ring.finish();
        }
    }
    // The next `count` bytes of a sequence that shows what is lost, doubled or out of order.
    bool append(size_t count) {
        std::array<uint8_t, 64> bytes{};
        for (size_t i = 0; i < count; ++i)
            bytes[i] = static_cast<uint8_t>(7 * (expected.size() + i));
        if (!ring.append(std::span(bytes).first(count))) return false;
        expected.insert(expected.end(), bytes.begin(),
                        bytes.begin() + static_cast<ptrdiff_t>(count));
        return true;
    }

    SendRing<Bytes> ring{kUart7, DmaStream(1, 1, 5)};
    std::vector<uint8_t> sent;
    std::vector<uint8_t> expected;

  private:
    chip::MappedRam ram_;
    chip::Chip chip_{ram_, 24'000'000};
};

TEST_F(Ring, a_byte_takes_ten_bits_of_an_eighth_of_the_clock) {
    ASSERT_TRUE(append(21));
    run_us(39);
    EXPECT_EQ(sent.size(), 20U);
    run_us(2);
    EXPECT_EQ(sent, expected);
}

TEST_F(Ring, pieces_of_all_sizes_come_out_in_order) {
    for (size_t i = 0; i < 500; ++i) {
        ASSERT_TRUE(append(1 + i % 40)) << i;
        run_us(2 * (i % 40) + 3);
    }
    run_us(200);
    EXPECT_EQ(sent, expected);
}

TEST_F(Ring, what_finds_no_room_is_refused_as_a_whole) {
    ASSERT_TRUE(append(60));
    EXPECT_FALSE(append(5));
    ASSERT_TRUE(append(4));
    EXPECT_FALSE(append(1));
    run_us(200);
    EXPECT_EQ(sent, expected);
    ASSERT_TRUE(append(64));
    run_us(200);
    EXPECT_EQ(sent, expected);
}

}  // namespace
}  // namespace stator::stm32f4
