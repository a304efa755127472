// The simulated world of one flight: the quadrotor, its sensors, and what happens when. Knows no
// graph, no executor and no file.
#pragma once

#include "flight_watch.hpp"
#include "sensors.hpp"

namespace stator::board {

class World {
  public:
    // `seed` decides where the vehicle starts, its sensors' biases and all noise.
    explicit World(std::uint64_t seed);

    // What `move_to_next_event` found. `mocap` holds the measurement that arrived.
    struct Event {
        bool imu_sampled = false;
        bool mocap_received = false;
        ImuSample imu{};
        MocapSample mocap{};
    };

    std::uint64_t next_event_us() const;
    Event move_to_next_event();
    // The command acts from `now_us` on, which is not before the newest event.
    void command_motors(std::uint64_t now_us, const std::array<float, kRotors>& control);

    const Plant& plant() const { return plant_; }
    const FlightWatch& watch() const { return watch_; }
    bool is_over() const { return watch_.is_over(plant_.time_us()); }

  private:
    ImuParameters imu_parameters_{};
    MocapParameters mocap_parameters_{};
    Plant plant_;
    Imu imu_;
    Mocap mocap_;
    FlightWatch watch_;
    bool motors_are_stopped_ = true;
    std::uint64_t next_imu_us_ = 0;
    std::uint64_t next_picture_us_ = 0;
    std::uint64_t next_arrival_us_;
    MocapSample on_its_way_{};
};

}  // namespace stator::board
