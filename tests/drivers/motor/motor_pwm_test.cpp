// Commands as pulses of the chip's timers, as a speed controller sees them.
#include "motor_pwm.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "chip/timer.hpp"
#include "fixture.hpp"
#include "stator/testing.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/pwm.hpp"

namespace stator::drivers::motor::pwm {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

MotorPwm::Pulses written;
unsigned writes = 0;
void keep(const MotorPwm::Pulses& pulses_us) {
    written = pulses_us;
    ++writes;
}

TEST(MotorPwm, a_width_is_linear_in_the_thrust_and_clamped) {
    MotorPwm::Device device{.write = keep};
    MotorPwm driver(device);
    const ActuatorMotors command{.control = {0.0F, 1.0F, 0.5F, kNotANumber, 1.5F, -0.1F}};
    MotorPorts ports{.now = 0, .command = Input(command, true, 0)};
    driver.step(ports);
    EXPECT_EQ(written, (MotorPwm::Pulses{1075, 1950, 1513, 900, 1950, 900}));
}

TEST(MotorPwm, without_a_command_nothing_is_written) {
    MotorPwm::Device device{.write = keep};
    MotorPwm driver(device);
    const unsigned before = writes;
    MotorPorts ports{.now = 0};
    driver.step(ports);
    EXPECT_EQ(writes, before);
}

TEST(MotorPwm, a_timer_stops_motors_that_nothing_commands_any_more) {
    MotorPwm::Device device{.write = keep};
    MotorPwm driver(device);
    const ActuatorMotors command{.control = {0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F}};
    MotorPorts ports{.now = 1'000'000, .command = Input(command, true, 0)};
    driver.step(ports);
    const unsigned before = writes;
    MotorPorts soon{.now = 2'300'000};
    driver.step(soon);
    EXPECT_EQ(writes, before);
    MotorPorts late{.now = 2'300'001};
    driver.step(late);
    EXPECT_EQ(written, (MotorPwm::Pulses{900, 900, 900, 900, 900, 900}));
}

class Outputs : public chip::OnChip {
  public:
    Outputs() {
        EXPECT_EQ(stm32f4::start_clocks(24), stm32f4::ClockSource::kCrystal);
        stm32f4::rcc::kApb2Enable.set(1U << 0);
        chip.timer(1).watch([this](unsigned channel, uint64_t high_ns, uint64_t period_ns) {
            EXPECT_EQ(period_ns, 2'500'000U);
            widths_us[channel].push_back(high_ns / 1000);
        });
    }
    std::array<std::vector<uint64_t>, 4> widths_us;
    stm32f4::PwmTimer timer{0x40010000, stm32f4::kApb2TimerClock_hz, true};
};

TEST_F(Outputs, a_new_width_counts_from_the_next_period_on) {
    timer.start(2'500, 0b1001);
    wait_us(2'600);
    timer.write(4, 1'500);
    wait_us(2'500);
    timer.write(4, 1'600);
    wait_us(2'500);
    EXPECT_EQ(widths_us[3], (std::vector<uint64_t>{0, 1500, 1600}));
    EXPECT_EQ(widths_us[0], (std::vector<uint64_t>{0, 0, 0}));
    EXPECT_TRUE(widths_us[1].empty());
}

}  // namespace
}  // namespace stator::drivers::motor::pwm
