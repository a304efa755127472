// The simulated world of one flight: the quadrotor, its sensors, its pilot, and what happens when.
// Knows no graph, no executor and no file.
#pragma once

#include <deque>
#include <optional>

#include "battery.hpp"
#include "conditions.hpp"
#include "flight_watch.hpp"
#include "navigation_sensors.hpp"
#include "sensors.hpp"
#include "variation.hpp"

namespace stator::board {

// Something that happens again and again.
struct Timer {
    std::uint64_t period_us;
    std::uint64_t next_us = 0;

    bool take(std::uint64_t now_us) {
        if (now_us < next_us) return false;
        next_us += period_us;
        return true;
    }
};

class World {
  public:
    explicit World(const Conditions& conditions);

    // A pilot's frame, and whether it has been heard since the last one.
    struct RadioFrame {
        PilotFrame hands{};
        bool is_heard = false;
    };
    // What `move_to_next_event` found; a measurement that arrived late was taken earlier.
    struct Event {
        std::optional<ImuSample> imu;
        std::optional<MocapSample> mocap;
        std::optional<Vector3f> mag_B;  // gauss
        std::optional<BarometerSample> baro;
        std::optional<GnssFix> gnss;
        std::optional<RadioFrame> radio;
        bool battery_measured = false;
    };

    static constexpr std::uint64_t kBatteryPeriod_us = 50000;

    std::uint64_t next_event_us() const { return imu_timer_.next_us; }
    Event move_to_next_event();
    // The command acts from `now_us` on or, of a varied vehicle, after its delay. `now_us`
    // is not before the newest event.
    void command_motors(std::uint64_t now_us, const std::array<float, kRotors>& control);

    const Plant& plant() const { return plant_; }
    const Battery& battery() const { return battery_; }
    const FlightWatch& watch() const { return watch_; }
    bool mission_is_lost() const;
    bool is_over() const { return watch_.is_over(plant_.time_us()); }

  private:
    void move_plant(std::uint64_t time_us);
    void influence_plant(std::uint64_t now_us);
    std::optional<MocapSample> watch_with_cameras(std::uint64_t now_us);
    std::optional<GnssFix> listen_to_satellites(std::uint64_t now_us);
    const RadioFrame& listen_to_pilot(std::uint64_t now_us);

    Conditions conditions_;
    Vehicle vehicle_;
    MocapParameters mocap_parameters_{};
    GnssParameters gnss_parameters_{};
    Plant plant_;
    Battery battery_{BatteryParameters{}};
    Wind wind_;
    Imu imu_;
    Mocap mocap_;
    Magnetometer magnetometer_;
    Barometer barometer_;
    GnssReceiver gnss_;
    FlightWatch watch_;
    struct Command {
        std::uint64_t time_us;  // from when on it acts
        std::array<float, kRotors> control;
    };
    std::deque<Command> commands_;  // on their way
    bool motors_are_stopped_ = true;
    // All on the grid of the IMU's samples, so that nothing happens between two of them.
    Timer imu_timer_{vehicle_.imu.period_us};
    Timer picture_timer_{mocap_parameters_.period_us};
    Timer arrival_timer_{mocap_parameters_.period_us, mocap_parameters_.delay_us};
    Timer magnetometer_timer_{vehicle_.magnetometer.period_us};
    Timer barometer_timer_{vehicle_.barometer.period_us};
    Timer battery_timer_{kBatteryPeriod_us};
    Timer fix_timer_{gnss_parameters_.period_us};
    Timer radio_timer_{Pilot::kPeriod_us};
    MocapSample picture_{};                         // on its way
    std::optional<GnssReceiver::Sending> sending_;  // on its way
    RadioFrame radio_;                              // the newest one heard
};

}  // namespace stator::board
