// The simulated world of one flight: the vehicle, what acts on it, and what happens when. Sensors
// look at it from outside: each is a part of its own (README.md). Knows no graph, no executor and
// no file.
#pragma once

#include <deque>

#include "world/battery.hpp"
#include "world/conditions.hpp"
#include "world/flight_watch.hpp"
#include "world/variation.hpp"

namespace stator::world {

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
    // All that happens is on this grid.
    static constexpr std::uint64_t kStep_us = 1000;

    World(const Conditions& conditions, const Vehicle& published);

    std::uint64_t next_event_us() const { return next_event_us_; }
    // Then parts measure, before the next event or command. What acts on the vehicle from then on
    // is chosen, but acts on nothing that they see.
    void move_to_next_event();
    // The command acts from `now_us` on or, of a varied vehicle, after its delay. `now_us`
    // is not before the newest event.
    void command_motors(std::uint64_t now_us, const Controls& control);
    void command_servos(std::uint64_t now_us, const ServoControls& control);

    std::uint64_t time_us() const { return plant_.time_us(); }
    const Conditions& conditions() const { return conditions_; }
    const Vehicle& vehicle() const { return vehicle_; }
    const Plant& plant() const { return plant_; }
    const Battery& battery() const { return battery_; }
    // What acts on the vehicle until the next event.
    const Influence& influence() const { return influence_; }
    const FlightWatch& watch() const { return watch_; }
    bool has_fault(FaultKind kind) const;
    bool is_over() const { return !conditions_.is_endless && watch_.is_over(plant_.time_us()); }

  private:
    void move_plant(std::uint64_t time_us);
    void choose_influence(std::uint64_t now_us);
    double supply(std::uint64_t now_us);
    void choose_air();
    void push_command(std::uint64_t now_us);

    Conditions conditions_;
    Vehicle vehicle_;
    Plant plant_;
    Battery battery_;
    Wind wind_;
    Influence influence_{};
    Launcher launcher_;
    FlightWatch watch_;
    struct Command {
        std::uint64_t time_us;  // from when on it acts
        Controls control;
        ServoControls servos;
    };
    std::deque<Command> commands_;  // on their way
    Controls obeyed_{};             // the newest command of each motor that is not stuck
    ServoControls obeyed_servos_{};
    double weakness_ = 1.0;  // of a supply that gives too little current
    bool motors_are_stopped_ = true;
    std::uint64_t next_event_us_ = 0;
};

}  // namespace stator::world
