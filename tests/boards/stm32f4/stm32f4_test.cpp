// The drivers of the STM32F4 against a model of its registers. Addresses and bits are of RM0090,
// written out here a second time, so that a wrong one in the driver shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "stm32f4/backup.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/flash.hpp"
#include "stm32f4/gpio.hpp"
#include "stm32f4/timer.hpp"
#include "stm32f4/usart.hpp"
#include "stm32f4/watchdog.hpp"

namespace stator::stm32f4 {
namespace {

constexpr uint32_t kRccCr = 0x40023800;
constexpr uint32_t kRccPllcfgr = 0x40023804;
constexpr uint32_t kRccCfgr = 0x40023808;
constexpr uint32_t kFlashAcr = 0x40023C00;

// Oscillators that get ready after some reads, a PLL that locks if it has an input, and a switch.
struct ClockModel : RegisterModel {
    bool has_crystal = true;
    bool pll_locks = true;

    ClockModel() {
        words[kRccCr] = 1U << 0 | 1U << 1;  // after reset the internal oscillator runs
        words[kRccPllcfgr] = 0x24003010;
        on_read[kRccCr] = [this] {
            uint32_t& control = words[kRccCr];
            if (has_crystal && (control & 1U << 16) != 0) control |= 1U << 17;
            if ((control & 1U << 16) == 0) control &= ~(1U << 17);
            const bool pll_on = (control & 1U << 24) != 0;
            if (pll_on && pll_locks) control |= 1U << 25;
            if (!pll_on) control &= ~(1U << 25);
            return control;
        };
        on_read[kRccCfgr] = [this] {
            const uint32_t value = words[kRccCfgr];
            return (value & ~0xCU) | (value & 3U) << 2;
        };
    }
};

TEST(ClockTree, runs_at_168_mhz_from_the_crystal) {
    ClockModel model;
    ASSERT_EQ(start_clocks(24), ClockSource::kCrystal);
    // 6.3.2: VCO = 24 MHz / M * N, core = VCO / P, USB = VCO / Q; source: the crystal.
    const uint32_t pll = model.words[kRccPllcfgr];
    const uint32_t vco_mhz = 24 / (pll & 0x3FU) * (pll >> 6 & 0x1FFU);
    EXPECT_EQ(vco_mhz / (2 * (pll >> 16 & 3U) + 2), 168U);
    EXPECT_EQ(vco_mhz / (pll >> 24 & 0xFU), 48U);
    EXPECT_NE(pll & 1U << 22, 0U);
    EXPECT_EQ(model.words[kRccCfgr] & 3U, 2U);        // the PLL is the system clock
    EXPECT_EQ(model.words[kRccCfgr] >> 10 & 7U, 5U);  // APB1: by 4, 42 MHz
    EXPECT_EQ(model.words[kRccCfgr] >> 13 & 7U, 4U);  // APB2: by 2, 84 MHz
    EXPECT_EQ(model.words[kFlashAcr] & 0xFU, 5U);     // table 11
}

TEST(ClockTree, raises_the_wait_states_before_the_clock) {
    ClockModel model;
    ASSERT_EQ(start_clocks(24), ClockSource::kCrystal);
    const auto flash = std::ranges::find_if(
        model.writes, [](const auto& write) { return write.first == kFlashAcr; });
    const auto to_pll = std::ranges::find_if(model.writes, [](const auto& write) {
        return write.first == kRccCfgr && (write.second & 3U) == 2;
    });
    EXPECT_LT(flash, to_pll);
}

TEST(ClockTree, falls_back_to_the_internal_oscillator_without_a_crystal) {
    ClockModel model;
    model.has_crystal = false;
    ASSERT_EQ(start_clocks(24), ClockSource::kInternal);
    const uint32_t pll = model.words[kRccPllcfgr];
    EXPECT_EQ(16 / (pll & 0x3FU) * (pll >> 6 & 0x1FFU) / 2, 168U);
    EXPECT_EQ(pll & 1U << 22, 0U);
    EXPECT_EQ(model.words[kRccCr] & 1U << 16, 0U);
}

TEST(ClockTree, gives_up_on_a_pll_that_never_locks) {
    ClockModel model;
    model.pll_locks = false;
    EXPECT_EQ(start_clocks(24), ClockSource::kNone);
    EXPECT_LT(model.reads, 200'000U);
}

TEST(ClockTree, stops_a_pll_that_a_bootloader_left_running_before_setting_it) {
    ClockModel model;
    model.words[kRccCr] |= 1U << 16 | 1U << 24;
    model.words[kRccCfgr] = 2;
    model.on_write[kRccPllcfgr] = [&model](uint32_t) {
        EXPECT_EQ(model.words[kRccCfgr] & 3U, 0U);
        EXPECT_EQ(model.words[kRccCr] & 1U << 24, 0U);
    };
    EXPECT_EQ(start_clocks(24), ClockSource::kCrystal);
}

TEST(ResetCause, is_told_once) {
    RegisterModel model;
    model.words[0x40023874] = 1U << 29 | 1U << 26;
    model.on_write[0x40023874] = [&model](uint32_t value) {
        if ((value & 1U << 24) != 0) model.words[0x40023874] = 0;
    };
    const ResetCause cause = take_reset_cause();
    EXPECT_TRUE(cause.by_watchdog);
    EXPECT_TRUE(cause.by_pin);
    EXPECT_FALSE(cause.by_software);
    EXPECT_FALSE(take_reset_cause().by_watchdog);
}

TEST(Pin, drives_its_level_before_it_is_an_output) {
    RegisterModel model;
    Pin('C', 13).make_output(true);
    EXPECT_EQ(model.words[0x40023830], 1U << 2);   // the clock of port C
    EXPECT_EQ(model.words[0x40020818], 1U << 13);  // set
    EXPECT_EQ(model.words[0x40020800], 1U << 26);  // output
    EXPECT_EQ(model.writes.back().first, 0x40020800U);
    Pin('C', 13).write(false);
    EXPECT_EQ(model.words[0x40020818], 1U << 29);
}

// 8.4.2: what hangs on an anode at 5 V is never pulled up to 3.3 V.
TEST(Pin, of_an_open_drain_does_not_drive_high) {
    RegisterModel model;
    Pin('E', 12).make_open_drain(true);
    EXPECT_EQ(model.words[0x40021004], 1U << 12);
    EXPECT_EQ(model.words[0x40021018], 1U << 12);
    EXPECT_EQ(model.words[0x40021000], 1U << 24);
    EXPECT_EQ(model.writes.back().first, 0x40021000U);
}

TEST(Pin, of_the_backup_supply_is_slow) {
    RegisterModel model;
    for (uint32_t number = 12; number < 16; ++number) Pin('C', number).make_output(true);
    EXPECT_EQ(model.words[0x40020808], 1U << 24);
}

TEST(Pin, keeps_its_neighbours_functions) {
    RegisterModel model;
    model.words[0x40020C20] = 0x11111111;
    Pin('D', 5).make_alternate(7);  // USART2_TX
    EXPECT_EQ(model.words[0x40020C20], 0x11711111U);
    EXPECT_EQ(model.words[0x40020C00], 2U << 10);
}

TEST(MicrosecondTimer, counts_microseconds_of_an_84_mhz_timer_clock) {
    RegisterModel model;
    MicrosecondTimer().start();
    EXPECT_EQ(model.words[0x40000C28], 83U);
    EXPECT_EQ(model.words[0x40000C2C], 0xFFFFFFFFU);
    EXPECT_EQ(model.words[0x40000C00], 1U);
    model.words[0x40000C24] = 77;
    EXPECT_EQ(MicrosecondTimer().us(), 77U);
}

TEST(Watchdog, starts_with_its_time_and_is_kicked_by_the_key) {
    RegisterModel model;
    ASSERT_TRUE(Watchdog().start(250));
    EXPECT_EQ(model.words[0x40003004], 3U);  // 32 kHz / 32
    EXPECT_EQ(model.words[0x40003008], 249U);
    EXPECT_EQ(model.words[0x40003000], 0xAAAAU);
    EXPECT_EQ(model.writes.front().second, 0xCCCCU);
}

TEST(Watchdog, says_that_the_hardware_did_not_take_its_time) {
    RegisterModel model;
    model.words[0x4000300C] = 1;
    EXPECT_FALSE(Watchdog().start(250));
    EXPECT_EQ(model.words[0x40003000], 0xAAAAU);
}

TEST(BackupDomain, is_writable_once_open) {
    RegisterModel model;
    BackupDomain().open();
    EXPECT_EQ(model.words[0x40007000], 1U << 8);
    BackupDomain().write(3, 0xCAFE);
    EXPECT_EQ(model.words[0x40002860], 0xCAFEU);
    EXPECT_EQ(BackupDomain().read(3), 0xCAFEU);
}

// RTC_BKP0R to RTC_BKP19R.
TEST(BackupDomain, leaves_the_mailbox_of_the_bootloader_alone) {
    RegisterModel model;
    for (unsigned i = 0; i < BackupDomain::kRegisters; ++i) BackupDomain().write(i, 0xB007B007);
    EXPECT_FALSE(model.words.contains(0x40002850));
    EXPECT_TRUE(model.words.contains(0x4000289C));
    EXPECT_FALSE(model.words.contains(0x400028A0));
}

// 3.9.2 to 3.9.5: locked until both keys came; an operation sets status bits.
struct FlashModel : RegisterModel {
    uint32_t status_of_operation = 0;
    bool has_first_key = false;

    FlashModel() {
        words[kControl] = 1U << 31;
        on_write[kKeys] = [this](uint32_t key) {
            if (key == 0xCDEF89AB && has_first_key) words[kControl] &= ~(1U << 31);
            has_first_key = key == 0x45670123;
        };
        on_write[kControl] = [this](uint32_t value) {
            if ((value & 1U << 16) != 0) words[kStatus] = status_of_operation;
        };
        on_write[kStatus] = [this](uint32_t value) {
            words[kStatus] = status_of_operation & ~value;
        };
    }
    static constexpr uint32_t kKeys = 0x40023C04;
    static constexpr uint32_t kStatus = 0x40023C0C;
    static constexpr uint32_t kControl = 0x40023C10;
};

TEST(Flash, erases_the_sector_and_locks_again) {
    FlashModel model;
    std::vector<uint32_t> controls;
    EXPECT_EQ(erase_sector(5), FlashStatus::kDone);
    for (const auto& [address, value] : model.writes) {
        if (address == FlashModel::kControl) controls.push_back(value);
    }
    const uint32_t erase = 1U << 1 | 5U << 3 | 2U << 8;
    EXPECT_EQ(controls, (std::vector<uint32_t>{erase, erase | 1U << 16, 1U << 31}));
}

TEST(Flash, programs_a_word) {
    FlashModel model;
    EXPECT_EQ(program_word(0x080E0000, 42), FlashStatus::kDone);
    EXPECT_EQ(model.words[0x080E0000], 42U);
}

TEST(Flash, tells_protection_from_failure) {
    FlashModel model;
    model.status_of_operation = 1U << 4;
    EXPECT_EQ(erase_sector(1), FlashStatus::kProtected);
    model.status_of_operation = 1U << 7;
    EXPECT_EQ(erase_sector(1), FlashStatus::kFailed);
}

TEST(Flash, does_not_wait_for_ever) {
    FlashModel model;
    model.words[FlashModel::kStatus] = 1U << 16;
    EXPECT_EQ(program_word(0x080E0000, 42), FlashStatus::kBusy);
    EXPECT_EQ(model.words.count(0x080E0000), 0U);
}

struct TestLink;
using Sent = DmaBuffer<TestLink, 8>;
struct TestLinkBack;
using Received = DmaBuffer<TestLinkBack, 8>;

// USART2 on DMA1: stream 6 sends, stream 5 receives, channel 4 (RM0090, table 42).
constexpr uint32_t kUsart2 = 0x40004400;
constexpr uint32_t kSendStream = 0x40026010 + 0x18 * 6;
constexpr uint32_t kReceiveStream = 0x40026010 + 0x18 * 5;

Usart<Sent, Received> usart() {
    return {kUsart2, DmaStream(1, 6, 4), DmaStream(1, 5, 4)};
}

TEST(Usart, sets_its_rate_and_receives_around_a_ring) {
    RegisterModel model;
    auto link = usart();
    ASSERT_TRUE(link.start(kApb1Clock_hz, 57600));
    EXPECT_EQ(model.words[kUsart2 + 0x08], 729U);  // 42 MHz / 57600 = 729.2
    EXPECT_EQ(model.words[kReceiveStream] >> 25, 4U);
    EXPECT_EQ(model.words[kReceiveStream] & 0x501U, 0x501U);  // enabled, memory counts, circular
    EXPECT_EQ(model.words[kReceiveStream + 0x04], 8U);
    EXPECT_EQ(model.words[kReceiveStream + 0x08], kUsart2 + 0x04);

    model.words[kReceiveStream + 0x04] = 8 - 3;
    std::ranges::copy(std::array<uint8_t, 3>{1, 2, 3}, Received::bytes);
    std::array<uint8_t, 8> got{};
    EXPECT_EQ(link.read(got), 3U);
    EXPECT_EQ(got[2], 3);
    EXPECT_EQ(link.read(got), 0U);
    Received::bytes[7] = 9;
    Received::bytes[0] = 10;
    model.words[kReceiveStream + 0x04] = 8 - 1;  // around
    EXPECT_EQ(link.read(got), 6U);
    EXPECT_EQ(got[4], 9);
    EXPECT_EQ(got[5], 10);
}

TEST(Usart, sends_what_fits_and_nothing_while_it_is_busy) {
    RegisterModel model;
    const auto link = usart();
    EXPECT_EQ(link.write(std::array<uint8_t, 10>{5, 6}), 8U);
    EXPECT_EQ(Sent::bytes[1], 6);
    EXPECT_EQ(model.words[kSendStream + 0x04], 8U);
    EXPECT_EQ(model.words[kSendStream] & 0x441U, 0x441U);  // enabled, memory counts, to the USART
    // Stream 6: bit 16 of DMA_HIFCR on (10.5.4).
    EXPECT_EQ(model.words[0x4002600C], 0x3DU << 16);
    EXPECT_EQ(link.write(std::array<uint8_t, 1>{7}), 0U);
    model.words[kSendStream] &= ~1U;
    EXPECT_EQ(link.write(std::array<uint8_t, 1>{7}), 1U);
}

// What compiler and memory hold back comes through at a barrier, no sooner.
TEST(Usart, what_is_sent_is_in_memory_before_the_stream_starts) {
    RegisterModel model;
    uint8_t in_memory = 0;
    uint8_t sent = 0;
    model.on_barrier = [&] { in_memory = Sent::bytes[0]; };
    model.on_write[kSendStream] = [&](uint32_t value) {
        if ((value & 1U) != 0) sent = in_memory;
    };
    EXPECT_EQ(usart().write(std::array<uint8_t, 1>{77}), 1U);
    EXPECT_EQ(sent, 77);
}

TEST(Usart, reads_its_ring_after_it_knows_how_far_it_is_filled) {
    RegisterModel model;
    auto link = usart();
    Received::bytes[0] = 0;
    bool asked = false;
    model.on_read[kReceiveStream + 0x04] = [&] {
        asked = true;
        return 8U - 1U;
    };
    model.on_barrier = [&] {
        if (asked) Received::bytes[0] = 78;
    };
    std::array<uint8_t, 8> got{};
    EXPECT_EQ(link.read(got), 1U);
    EXPECT_EQ(got[0], 78);
}

TEST(DmaStream, starts_nothing_over_a_stream_that_does_not_stop) {
    RegisterModel model;
    model.on_read[kSendStream] = [] { return 1U; };
    EXPECT_FALSE(DmaStream(1, 6, 4).send(kUsart2 + 4, Sent::bytes, 4));
    EXPECT_EQ(model.words.count(kSendStream + 0x0C), 0U);
}

}  // namespace
}  // namespace stator::stm32f4
