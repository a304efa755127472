// The MPU6000 from its supply to a published sample: driver, bus, DMA, ready line and tick on the
// model of the chip, with a model of the part behind it. And what is seen of its faults.
#include "parts/mpu6000.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "imu_mpu6000.hpp"
#include "mapped_ram.hpp"
#include "stator/registers.hpp"
#include "stator/testing.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/edge_line.hpp"
#include "stm32f4/spi.hpp"
#include "stm32f4/timer.hpp"

namespace stator::drivers::imu::mpu6000 {
namespace {

using Ram = chip::MappedRam;
struct Sent {
    static inline uint8_t* const bytes = Ram::bytes();
};
struct Received {
    static inline uint8_t* const bytes = Ram::bytes() + 64;
};

constexpr unsigned kTick = 29, kReady = 40, kEnd = 58;  // TIM3, EXTI15_10, DMA2 stream 2

constexpr stm32f4::Spi<Sent, Received> kBus(0x40013000, stm32f4::DmaStream(2, 3, 3),
                                            stm32f4::DmaStream(2, 2, 3));

class Imu : public ::testing::Test {
  public:
    Imu() {
        current_chip = &chip_;
        EXPECT_EQ(stm32f4::start_clocks(24), stm32f4::ClockSource::kCrystal);
        stm32f4::rcc::kApb2Enable.set(1U << 12);
        chip_.spi("SPI1").attach(part, chip::pin('C', 2));
        stm32f4::Pin('C', 2).make_output(true);
        kBus.start();
        line_.start();
        tick_.start();
        device.axes = {2, -1, 3};
    }
    ~Imu() override { current_chip = nullptr; }

    void run_ms(uint64_t time_ms) {
        const uint64_t end_ns = chip_.now_ns() + time_ms * 1'000'000;
        while (chip_.now_ns() < end_ns) {
            chip_.move(std::min(chip_.visible_ns(), end_ns));
            if (is_raised(kReady)) {
                line_.acknowledge();
                on_bus_.ready(now_us());
            }
            if (is_raised(kTick)) {
                tick_.acknowledge();
                if (on_bus_.tick(now_us())) activate();
            }
            if (is_raised(kEnd) && on_bus_.finish()) activate();
        }
    }

    ImuMpu6000::Device device;
    chip::Mpu6000::Motion motion{.rate = {0.1, 0.2, 0.3}, .force = {1, 2, -9.8}};
    double noise = 0.003;
    std::optional<ImuCalibration> calibration;
    std::vector<SensorGyro> gyro;
    std::vector<SensorAccel> accel;

  private:
    bool is_raised(unsigned line) const {
        return (chip_.levels()[line / 32] >> line % 32 & 1) != 0;
    }
    uint64_t now_us() const { return chip_.now_ns() / 1000; }
    void activate() {
        ImuPorts ports{.now = now_us(),
                       .calibration = calibration ? Input(*calibration) : Input<ImuCalibration>()};
        stator::testing::Probe published_accel(ports.accel, ports.now);
        stator::testing::Probe published_gyro(ports.gyro, ports.now);
        driver_.step(ports);
        if (published_accel.count() != 0) accel.push_back(published_accel.newest());
        if (published_gyro.count() != 0) gyro.push_back(published_gyro.newest());
    }

    Ram ram_;
    chip::Chip chip_{ram_, 24'000'000};

  public:
    chip::Mpu6000 part{chip_, chip::pin('D', 15), [this](uint64_t now_ns) {
                           chip::Mpu6000::Motion noisy = motion;
                           noisy.rate[0] +=
                               noise * (static_cast<double>(now_ns / 1'000'000 % 7) - 3);
                           return noisy;
                       }};

  private:
    ImuMpu6000 driver_{device};
    stm32f4::PartOnSpi<kBus, ImuMpu6000::Device> on_bus_{stm32f4::Pin('C', 2), {6, 3}, device};
    stm32f4::EdgeLine line_{'D', 15};
    stm32f4::MillisecondTick tick_;
};

TEST_F(Imu, starts_within_300_ms_and_publishes_each_sample) {
    run_ms(300);
    ASSERT_FALSE(gyro.empty());
    gyro.clear();
    const uint64_t before = part.samples();
    run_ms(2000);
    EXPECT_NEAR(static_cast<double>(part.samples() - before), 2000, 1);
    EXPECT_NEAR(static_cast<double>(gyro.size()), 2000, 1);
    for (size_t i = 1; i < gyro.size(); ++i) {
        EXPECT_EQ(gyro[i].timestamp_sample - gyro[i - 1].timestamp_sample, 1000U);
    }
    EXPECT_EQ(device.resets, 1U);
    EXPECT_EQ(device.bad, 0U);
}

TEST_F(Imu, a_sample_has_the_units_and_axes_of_the_body) {
    run_ms(300);
    ASSERT_FALSE(gyro.empty());
    EXPECT_NEAR(gyro.back().xyz[0], 0.2, 0.002);
    EXPECT_NEAR(gyro.back().xyz[1], -0.1, 0.011);
    EXPECT_NEAR(gyro.back().xyz[2], 0.3, 0.002);
    EXPECT_NEAR(accel.back().xyz[0], 2, 0.005);
    EXPECT_NEAR(accel.back().xyz[1], -1, 0.005);
    EXPECT_NEAR(accel.back().xyz[2], -9.8, 0.005);
    EXPECT_EQ(accel.back().timestamp_sample, gyro.back().timestamp_sample);
    // The line fell when it was measured; the burst took 23 us.
    EXPECT_NEAR(static_cast<double>(gyro.back().timestamp - gyro.back().timestamp_sample), 24, 3);
}

TEST_F(Imu, a_sample_is_calibrated) {
    calibration = ImuCalibration{.gyro_offset = {0.1F, 0.0F, -0.1F},
                                 .accel_offset = {0.0F, 0.5F, 0.0F},
                                 .accel_scale = {1.0F, 2.0F, 1.0F},
                                 .rotation = {0, 0, 1, 0, 1, 0, -1, 0, 0}};
    run_ms(300);
    ASSERT_FALSE(gyro.empty());
    EXPECT_NEAR(gyro.back().xyz[0], 0.3 + 0.1, 0.002);
    EXPECT_NEAR(gyro.back().xyz[2], -(0.2 - 0.1), 0.002);
    EXPECT_NEAR(accel.back().xyz[0], -9.8, 0.005);
    EXPECT_NEAR(accel.back().xyz[1], 2 * (-1 - 0.5), 0.01);
    EXPECT_NEAR(accel.back().xyz[2], -2, 0.005);
}

TEST_F(Imu, without_lines_it_is_read_by_the_tick_and_then_reset) {
    run_ms(300);
    part.faults.has_no_line = true;
    gyro.clear();
    run_ms(100);
    EXPECT_GT(gyro.size(), 90U);
    EXPECT_GT(device.missed_lines, 90U);
    run_ms(400);
    EXPECT_GE(device.resets, 2U);
}

TEST_F(Imu, a_part_that_is_silent_is_not_believed_and_comes_back) {
    run_ms(300);
    part.faults.is_silent = true;
    run_ms(5);
    gyro.clear();
    run_ms(1500);
    EXPECT_TRUE(gyro.empty());
    EXPECT_GT(device.bad, 5U);
    part.faults.is_silent = false;
    run_ms(1500);
    EXPECT_GT(gyro.size(), 100U);
}

TEST_F(Imu, a_part_that_is_stuck_is_reset) {
    run_ms(300);
    part.faults.is_stuck = true;
    run_ms(100);
    EXPECT_EQ(device.resets, 2U);
    EXPECT_GT(device.bad, 5U);
    part.faults.is_stuck = false;
    gyro.clear();
    run_ms(500);
    EXPECT_GT(gyro.size(), 100U);
}

TEST_F(Imu, registers_that_were_lost_are_written_again) {
    run_ms(300);
    part.brown_out();
    run_ms(20);
    gyro.clear();
    run_ms(1000);
    EXPECT_EQ(device.resets, 2U);
    EXPECT_GT(gyro.size(), 100U);
    EXPECT_NEAR(gyro.back().xyz[2], 0.3, 0.002);
}

TEST_F(Imu, another_part_in_its_place_is_never_believed) {
    part.faults.identity = 0x71;
    run_ms(3000);
    EXPECT_TRUE(gyro.empty());
    EXPECT_GE(device.resets, 3U);
}

}  // namespace
}  // namespace stator::drivers::imu::mpu6000
