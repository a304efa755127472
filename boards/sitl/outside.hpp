// The world of another simulator, as its messages show it: docs/hil.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "hil/link.hpp"
#include "samples.hpp"
#include "world/conditions.hpp"
#include "world/world.hpp"

namespace stator::board {

// In lockstep: the vehicle's clock stands still until the simulator's next HIL_SENSOR, and each is
// answered when all that was due at its time has run. So what the vehicle does depends on what the
// messages say and on their order, never on when they come. The vehicle's time 0 is that of the
// first HIL_SENSOR.
class Outside {
  public:
    using Control = world::Controls;

    Outside(const world::Conditions& conditions, const world::Vehicle& vehicle);

    // Waits for the simulator. Empty: done, or a signal came. Else what is wrong.
    [[nodiscard]] std::string connect(const char* place);

    // Answers the newest HIL_SENSOR, if it is due, and waits for the next. At the end: `now_us`.
    std::uint64_t next_event_us(std::uint64_t now_us);
    // What the message brings that is due.
    void take(Samples& samples);
    // Not a number: stopped.
    void command_motors(const Control& control);

    std::uint64_t time_us() const { return time_us_; }
    // The motors have stood still for a second after the flight.
    bool is_over() const;
    bool motors_are_stopped() const { return motors_are_stopped_; }
    bool motors_have_run() const { return motors_have_run_; }
    // The simulator went away, or sent what cannot be. Empty: not so.
    const std::string& problem() const { return problem_; }

  private:
    void answer();
    void send_heartbeat();
    std::uint8_t mode() const;
    bool accept(const mav::HilSensor& sensor);
    void end(std::string problem);
    void take_sensor(Samples& samples);
    void take_fix(Samples& samples);
    void take_parts(Samples& samples);

    hil::Link link_{{.system = 1, .component = 1}};
    const world::Conditions& conditions_;
    const world::Vehicle& vehicle_;
    mav::HilSensor sensor_{};  // the newest
    mav::HilGps fix_{};
    bool has_sensor_ = false;  // which is to come, or is due and not answered
    bool is_taken_ = false;    // what it brings has been given to the devices
    bool has_fix_ = false;
    bool is_first_ = true;
    std::uint64_t first_us_ = 0;  // the simulator's time at the vehicle's 0
    std::uint64_t time_us_ = 0;   // of `sensor_`, the vehicle's
    world::Timer heartbeat_timer_{.period_us = 1'000'000};
    world::Timer radio_timer_{.period_us = world::Pilot::kPeriod_us};
    world::Timer battery_timer_{.period_us = 50'000};
    Control control_;
    bool motors_are_stopped_ = true;
    bool motors_have_run_ = false;
    std::uint64_t stopped_us_ = 0;
    std::string problem_;
};

}  // namespace stator::board
