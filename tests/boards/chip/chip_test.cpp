// The model of the chip, by what RM0090 says: addresses and bits are written out here a second
// time. And the drivers of the family run on it, which only a strict model makes a test of.
#include <cstdint>
#include <string>
#include <vector>

#include "chip/spi.hpp"
#include "chip/timer.hpp"
#include "chip/usart.hpp"
#include "fixture.hpp"
#include "stm32f4/backup.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/gpio.hpp"
#include "stm32f4/timer.hpp"
#include "stm32f4/watchdog.hpp"

namespace stator::chip {
namespace {

constexpr uint32_t kRccCr = 0x40023800, kRccPllcfgr = 0x40023804, kRccCfgr = 0x40023808,
                   kAhb1Enable = 0x40023830, kApb1Enable = 0x40023840, kApb2Enable = 0x40023844,
                   kRccCsr = 0x40023874;
constexpr uint32_t kFlashAcr = 0x40023C00;

using stm32f4::ClockSource;

class ClockTree : public OnChip {};

TEST_F(ClockTree, starts_with_the_internal_oscillator) {
    EXPECT_EQ(chip.clocks().core_hz, 16'000'000U);
    EXPECT_EQ(read(kRccCr) & 0x3, 0x3U);
}

TEST_F(ClockTree, the_driver_reaches_168_mhz_without_a_broken_rule) {
    ASSERT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal);
    EXPECT_EQ(chip.clocks().core_hz, 168'000'000U);
    EXPECT_EQ(chip.clocks().apb1_hz, 42'000'000U);
    EXPECT_EQ(chip.clocks().apb2_hz, 84'000'000U);
    EXPECT_EQ(chip.clocks().apb1_timer_hz, 84'000'000U);
    EXPECT_EQ(chip.clocks().apb2_timer_hz, 168'000'000U);
}

TEST_F(ClockTree, the_driver_starts_again_with_the_pll_on) {
    ASSERT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal);
    ASSERT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal);
}

TEST(ClockTreeWithoutCrystal, the_driver_takes_the_internal_oscillator) {
    Ram ram;
    Chip chip(ram, 0);
    current_chip = &chip;
    EXPECT_EQ(stm32f4::start_clocks(24), ClockSource::kInternal);
    EXPECT_EQ(chip.clocks().core_hz, 168'000'000U);
    current_chip = nullptr;
}

TEST_F(ClockTree, a_clock_that_is_not_ready_is_refused) {
    write(kRccCr, read(kRccCr) | 1U << 16);
    EXPECT_EQ(broken_by([&] { write(kRccCfgr, 1); }), "RCC: switched to HSE, which is not ready");
    wait_us(2000);
    write(kRccCfgr, 1);
    EXPECT_EQ(read(kRccCfgr) & 0xC, 0x4U);
    EXPECT_EQ(chip.clocks().core_hz, 24'000'000U);
}

TEST_F(ClockTree, reserved_bits_must_keep_their_value) {
    EXPECT_EQ(broken_by([&] { write(kRccPllcfgr, 0x04003010); }),
              "RCC: reserved bits of RCC_PLLCFGR: expected 0x20000000, found 0x00000000");
}

TEST_F(ClockTree, too_few_wait_states_are_refused) {
    ASSERT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal);
    EXPECT_EQ(broken_by([&] { write(kFlashAcr, 4); }),
              "RCC: the core clock is above what the flash's wait states allow (3.5.1)");
}

TEST_F(ClockTree, a_running_pll_cannot_be_changed) {
    ASSERT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal);
    EXPECT_EQ(broken_by([&] { write(kRccPllcfgr, 0x24003010); }),
              "RCC: PLLCFGR changes while the PLL is on");
}

class Bus : public OnChip {};

TEST_F(Bus, a_peripheral_without_clock_is_refused) {
    EXPECT_EQ(broken_by([&] { write(0x40020000, 0); }), "GPIOA: written while its clock is off");
    EXPECT_EQ(broken_by([&] { read(0x40000C24); }), "TIM5: read while its clock is off");
}

TEST_F(Bus, what_is_not_there_is_refused) {
    EXPECT_EQ(broken_by([&] { read(0x40006400); }),
              "0x40006400: there is no peripheral, or it is not modelled");
    EXPECT_EQ(broken_by([&] { read(0x40023BFC); }),
              "RCC: offset 0x000003FC has no register, or it is not modelled");
    EXPECT_EQ(broken_by([&] { chip.write(0x08004000, 0, 4); }),
              "the flash is written, but not unlocked");
}

class Pinned : public OnChip {};

TEST_F(Pinned, an_output_drives_from_the_first_instant) {
    std::vector<bool> seen;
    chip.pins().watch(pin('E', 3), [&](bool is_high) { seen.push_back(is_high); });
    stm32f4::Pin('E', 3).make_output(true);
    EXPECT_EQ(seen, std::vector<bool>{true});
    stm32f4::Pin('E', 3).write(false);
    EXPECT_FALSE(chip.pins().is_high(pin('E', 3)));
}

TEST_F(Pinned, two_ends_that_drive_are_refused) {
    chip.pins().set_outside(pin('D', 15), Drive::kHigh);
    EXPECT_EQ(broken_by([&] { stm32f4::Pin('D', 15).make_output(false); }),
              "PD15: driven low by one end and high by the other");
}

TEST_F(Pinned, the_pins_of_the_backup_domain_are_slow) {
    write(kAhb1Enable, read(kAhb1Enable) | 1U << 2);
    EXPECT_EQ(broken_by([&] { write(0x40020808, 1U << 26); }),
              "GPIOC: PC13 to PC15 are set to more than 2 MHz (5.1.2)");
    stm32f4::Pin('C', 13).make_output(true);
}

TEST_F(Pinned, an_edge_raises_its_line_until_it_is_cleared) {
    write(kApb2Enable, 1U << 14);
    write(0x40013814, 3U << 12);  // SYSCFG_EXTICR4: line 15 is port D
    write(0x40013C0C, 1U << 15);  // EXTI_FTSR
    write(0x40013C00, 1U << 15);  // EXTI_IMR
    chip.pins().set_outside(pin('D', 15), Drive::kHigh);
    EXPECT_FALSE(is_raised(40));
    chip.pins().set_outside(pin('D', 15), Drive::kLow);
    EXPECT_TRUE(is_raised(40));
    write(0x40013C14, 1U << 15);  // EXTI_PR
    EXPECT_FALSE(is_raised(40));
    chip.pins().set_outside(pin('A', 15), Drive::kHigh);
    chip.pins().set_outside(pin('A', 15), Drive::kLow);
    EXPECT_FALSE(is_raised(40));
}

class Watched : public OnChip {};

TEST_F(Watched, resets_when_it_is_not_kicked) {
    ASSERT_TRUE(stm32f4::Watchdog{}.start(500));
    wait_us(499'000);
    stm32f4::Watchdog{}.kick();
    wait_us(499'000);
    EXPECT_FALSE(chip.take_reset_request());
    wait_us(2'000);
    EXPECT_TRUE(chip.take_reset_request());
    chip.reset();
    EXPECT_TRUE(stm32f4::take_reset_cause().by_watchdog);
    EXPECT_EQ(chip.clocks().core_hz, 16'000'000U);
}

TEST_F(Watched, its_values_are_protected) {
    EXPECT_EQ(broken_by([&] { write(0x40003008, 100); }),
              "IWDG: IWDG_RLR is written while it is protected (21.4.1)");
}

TEST_F(Watched, the_causes_of_a_reset_are_removed) {
    EXPECT_TRUE(stm32f4::take_reset_cause().by_power);
    EXPECT_EQ(read(kRccCsr) & 0xFE000000, 0U);
}

class Kept : public OnChip {};

TEST_F(Kept, survives_a_reset_and_is_protected) {
    const stm32f4::BackupDomain backup;
    EXPECT_EQ(broken_by([&] { backup.write(0, 1); }),
              "RTC: written while DBP of PWR_CR is 0 (5.1.2)");
    backup.open();
    backup.write(0, 0x12345678);
    chip.reset();
    EXPECT_EQ(backup.read(0), 0x12345678U);
}

class Timed : public OnChip {
  public:
    Timed() { EXPECT_EQ(stm32f4::start_clocks(24), ClockSource::kCrystal); }
};

TEST_F(Timed, the_clock_of_the_graph_counts_microseconds) {
    const stm32f4::MicrosecondTimer timer;
    timer.start();
    const uint32_t begin_us = timer.us();
    wait_us(123'456);
    EXPECT_NEAR(timer.us() - begin_us, 123'456, 1);
}

// As the emulator reads it (boards/qemu_machine): the same count that the chip says.
TEST_F(Timed, a_count_that_was_read_is_known_while_the_timer_runs) {
    const stm32f4::MicrosecondTimer timer;
    timer.start();
    EXPECT_EQ(chip.known(chip.visible_ns())[0].divider, 0U);
    static_cast<void>(timer.us());
    const wire::Counter known = chip.known(chip.visible_ns())[0];
    EXPECT_EQ(known.address, 0x40000C24U);
    EXPECT_GT(known.until_ns, chip.now_ns() + 4'000'000'000'000);
    for (const uint64_t us : {1U, 7U, 1'000U, 999'999U}) {
        wait_us(us);
        const uint32_t said = timer.us();
        const uint64_t clocks = (chip.now_ns() - known.from_ns) * known.clock_hz / 1'000'000'000;
        EXPECT_EQ(known.first + clocks / known.divider, said);
    }
    write(kApb1Enable, read(kApb1Enable) & ~(1U << 3));
    EXPECT_EQ(chip.known(chip.visible_ns())[0].divider, 0U);
}

TEST_F(OnChip, a_flag_that_was_read_is_known_until_it_may_change) {
    write(kRccCr, read(kRccCr) | 1U << 16);  // HSEON
    const uint32_t waiting = read(kRccCr);
    const uint64_t visible_ns = chip.visible_ns();
    const wire::Counter known = chip.known(visible_ns)[1];
    EXPECT_EQ(known.address, kRccCr);
    EXPECT_EQ(known.first, waiting);
    EXPECT_EQ(known.divider, 1U);
    EXPECT_EQ(known.until_ns, visible_ns);
    chip.move(visible_ns);
    EXPECT_EQ(chip.known(chip.visible_ns())[1].divider, 0U);
    EXPECT_NE(read(kRccCr), waiting);
    // Not what a read, or what happens unseen, changes.
    static_cast<void>(read(0x40023C00));
    EXPECT_EQ(chip.known(chip.visible_ns())[1].divider, 0U);
}

TEST_F(OnChip, what_the_processor_cannot_notice_is_not_visible_but_happens) {
    int happened = 0;
    chip.at(
        1000, [&] { ++happened; }, Effect::kUnseen);
    chip.at(2000, [&] { ++happened; });
    EXPECT_EQ(chip.visible_ns(), 2000U);
    chip.move(1500);
    EXPECT_EQ(happened, 1);
    chip.move(2000);
    EXPECT_EQ(happened, 2);
}

TEST_F(Timed, a_pulse_has_the_width_of_its_compare_value_from_the_next_period_on) {
    write(kApb1Enable, read(kApb1Enable) | 1U << 2);  // TIM4
    std::vector<uint64_t> high_us;
    chip.timer(4).watch([&](unsigned channel, uint64_t high_ns, uint64_t period_ns) {
        EXPECT_EQ(channel, 1U);
        EXPECT_EQ(period_ns, 2'500'000U);
        high_us.push_back(high_ns / 1000);
    });
    write(0x40000828, 83);      // PSC: 1 us
    write(0x4000082C, 2499);    // ARR: 400 Hz
    write(0x40000818, 0x6800);  // CCMR1: channel 2 in PWM mode 1, preload
    write(0x40000838, 1000);    // CCR2
    write(0x40000814, 1);       // EGR
    write(0x40000820, 0x10);    // CCER
    write(0x40000800, 0x81);    // CR1
    wait_us(3'000);
    write(0x40000838, 1900);
    wait_us(5'000);
    EXPECT_EQ(high_us, (std::vector<uint64_t>{1000, 1900, 1900}));
}

TEST_F(Timed, an_update_raises_its_line) {
    write(kApb1Enable, read(kApb1Enable) | 1U << 2);
    write(0x40000828, 83);
    write(0x4000082C, 99);
    write(0x40000814, 1);
    write(0x40000810, 0);  // SR: the update that EGR made
    write(0x4000080C, 1);  // DIER
    write(0x40000800, 1);
    wait_us(99);
    EXPECT_FALSE(is_raised(30));
    wait_us(2);
    EXPECT_TRUE(is_raised(30));
    write(0x40000810, 0);
    EXPECT_FALSE(is_raised(30));
}

// SPI1 with a part that answers each byte with its complement.
class Complement : public SpiPart {
  public:
    void select(bool is_selected) override { selected += is_selected ? 1 : 0; }
    uint8_t exchange(uint8_t sent, uint32_t clock_hz, unsigned mode) override {
        last_hz = clock_hz;
        last_mode = mode;
        return static_cast<uint8_t>(~sent);
    }
    int selected = 0;
    uint32_t last_hz = 0;
    unsigned last_mode = 0;
};

class SpiBus : public Timed {
  public:
    static constexpr uint32_t kCr1 = 0x40013000, kCr2 = 0x40013004, kSr = 0x40013008,
                              kDr = 0x4001300C;
    static constexpr uint32_t kOn = 0x037F & ~0x38U;  // master, mode 3, software select, enabled
    static constexpr uint32_t kDma2 = 0x40026400;
    Complement part;
    stm32f4::Pin select{'C', 2};

    SpiBus() {
        write(kApb2Enable, 1U << 12);
        write(kAhb1Enable, read(kAhb1Enable) | 1U << 22);
        select.make_output(true);
        chip.spi("SPI1").attach(part, pin('C', 2));
    }
    // DMA2: stream 2 receives, stream 3 sends; both in channel 3.
    void start_stream(unsigned stream, uint32_t memory, uint32_t count, uint32_t control) {
        const uint32_t at = kDma2 + 0x10 + 0x18 * stream;
        write(at + 0x04, count);
        write(at + 0x08, kDr);
        write(at + 0x0C, memory);
        write(at, control);
        write(at, control | 1);
    }
};

TEST_F(SpiBus, a_byte_takes_its_time) {
    write(kCr1, kOn | 3U << 3);  // 84 MHz / 16 = 5.25 MHz
    select.write(false);
    write(kDr, 0x5A);
    EXPECT_NE(read(kSr) & 0x80, 0U);
    wait_us(1);
    EXPECT_EQ(read(kSr) & 1, 0U);
    wait_us(1);
    EXPECT_EQ(read(kSr) & 0x83, 0x03U);
    EXPECT_EQ(read(kDr), 0xA5U);
    EXPECT_EQ(part.last_hz, 5'250'000U);
    EXPECT_EQ(part.last_mode, 3U);
    EXPECT_EQ(part.selected, 1);
}

TEST_F(SpiBus, without_a_selected_part_all_bits_are_one) {
    write(kCr1, kOn);
    write(kDr, 0);
    wait_us(2);
    EXPECT_EQ(read(kDr), 0xFFU);
}

TEST_F(SpiBus, a_byte_that_nothing_reads_is_an_overrun) {
    write(kCr1, kOn);
    write(kDr, 1);
    wait_us(2);
    write(kDr, 2);
    wait_us(2);
    EXPECT_NE(read(kSr) & 0x40, 0U);
    EXPECT_NE(read(kSr) & 0x40, 0U);
    read(kDr);
    read(kSr);
    EXPECT_EQ(read(kSr) & 0x40, 0U);
}

TEST_F(SpiBus, a_byte_before_there_is_room_is_refused) {
    write(kCr1, kOn | 7U << 3);
    write(kDr, 1);
    write(kDr, 2);
    EXPECT_EQ(broken_by([&] { write(kDr, 3); }),
              "SPI1: DR is written before the last byte has left it");
}

TEST_F(SpiBus, two_selected_parts_are_refused) {
    Complement other;
    chip.spi("SPI1").attach(other, pin('C', 13));
    stm32f4::Pin('C', 13).make_output(false);
    select.write(false);
    write(kCr1, kOn);
    write(kDr, 1);
    EXPECT_EQ(broken_by([&] { wait_us(2); }), "SPI1: two parts are selected: PC2 and PC13");
}

TEST_F(SpiBus, dma_moves_a_transfer_and_raises_its_line_once) {
    for (uint8_t i = 0; i < 15; ++i) ram.bytes[i] = i;
    select.write(false);
    write(kCr2, 3);
    write(kCr1, kOn | 3U << 3);
    start_stream(2, Ram::kAt + 100, 15, 3U << 25 | 1U << 10 | 1U << 4);
    start_stream(3, Ram::kAt, 15, 3U << 25 | 1U << 10 | 1U << 6);
    // 15 bytes at 5.25 MHz: 22.9 us, of which nothing is seen before the end.
    const uint64_t end_ns = chip.visible_ns();
    EXPECT_NEAR(static_cast<double>(end_ns - chip.now_ns()), 22'850, 400);
    chip.move(end_ns - 1);
    EXPECT_FALSE(is_raised(58));
    chip.move(end_ns);
    EXPECT_TRUE(is_raised(58));
    for (uint8_t i = 0; i < 15; ++i) EXPECT_EQ(ram.bytes[100 + i], static_cast<uint8_t>(~i));
    EXPECT_EQ(read(kDma2 + 0x10 + 0x18 * 2) & 1, 0U);
    EXPECT_EQ(broken_by([&] { start_stream(2, Ram::kAt + 100, 15, 3U << 25 | 1U << 10); }),
              "DMA2: stream 2 is enabled with flags of its last transfer (10.3.17)");
    write(kDma2 + 0x08, 0x3DU << 16);  // LIFCR
    EXPECT_FALSE(is_raised(58));
}

TEST_F(SpiBus, dma_does_not_reach_the_core_coupled_memory) {
    write(kCr2, 3);
    write(kCr1, kOn);
    EXPECT_EQ(broken_by([&] { start_stream(3, 0x10000000, 1, 3U << 25 | 1U << 10 | 1U << 6); }),
              "DMA2: stream 3 at 0x10000000, which it does not reach (2.1.3)");
}

TEST_F(SpiBus, a_stream_that_runs_is_not_configured) {
    start_stream(2, Ram::kAt, 15, 3U << 25 | 1U << 10);
    EXPECT_EQ(broken_by([&] { write(kDma2 + 0x10 + 0x18 * 2 + 0x04, 3); }),
              "DMA2: DMA2_SxNDTR is written while the stream is enabled (10.5)");
}

class Line : public Timed {
  public:
    static constexpr uint32_t kSr = 0x40004400, kDr = 0x40004404, kBrr = 0x40004408,
                              kCr1 = 0x4000440C;
    Line() {
        write(kApb1Enable, read(kApb1Enable) | 1U << 17);
        write(kBrr, 729);  // 42 MHz / 57,600
        write(kCr1, 0x202C);
    }
};

TEST_F(Line, a_byte_goes_out_after_its_time) {
    std::string sent;
    chip.usart("USART2").watch([&](uint8_t byte) { sent += static_cast<char>(byte); });
    write(kDr, 'a');
    wait_us(172);
    EXPECT_EQ(sent, "");
    wait_us(2);
    EXPECT_EQ(sent, "a");
    EXPECT_NE(read(kSr) & 0x40, 0U);
}

TEST_F(Line, a_byte_comes_in_and_one_too_many_is_an_overrun) {
    const uint8_t bytes[] = {'x', 'y'};
    chip.usart("USART2").arrive(bytes);
    wait_us(174);
    EXPECT_TRUE(is_raised(38));
    wait_us(174);
    EXPECT_NE(read(kSr) & 0x8, 0U);
    EXPECT_EQ(read(kDr), static_cast<uint32_t>('x'));
    EXPECT_FALSE(is_raised(38));
    EXPECT_EQ(read(kSr) & 0x28, 0U);
}

TEST_F(Line, with_eightfold_sampling_bit_3_of_the_divider_is_reserved) {
    EXPECT_EQ(broken_by([&] { write(kCr1, 0xA02C); }),
              "USART2: BRR has bit 3 with eightfold sampling (30.6.3)");
}

TEST_F(Line, with_eightfold_sampling_a_bit_is_an_eighth_of_what_the_divider_says) {
    std::string sent;
    chip.usart("USART2").watch([&](uint8_t byte) { sent += static_cast<char>(byte); });
    write(kCr1, 0);
    write(kBrr, 0x12);  // 8 + 2 clocks a bit: 2.38 us a byte
    write(kCr1, 0xA00C);
    write(kDr, 'a');
    chip.move(chip.now_ns() + 2'330);
    EXPECT_EQ(sent, "");
    chip.move(chip.now_ns() + 60);
    EXPECT_EQ(sent, "a");
}

TEST_F(Line, a_byte_without_room_is_refused) {
    write(kDr, 1);
    write(kDr, 2);
    EXPECT_EQ(broken_by([&] { write(kDr, 3); }),
              "USART2: DR is written before the last byte has left it");
}

}  // namespace
}  // namespace stator::chip
