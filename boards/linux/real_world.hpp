// The simulated world in real time: a thread beside the graph's, in which every event of the world
// happens when its time has come.
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <cstdio>

#include "drivers/baro/sim/baro_sim.hpp"
#include "drivers/battery/sim/battery_sim.hpp"
#include "can_link.hpp"
#include "can_parts.hpp"
#include "drivers/motor/sim/motor_sim.hpp"
#include "stator/mutex.hpp"
#include "stator/pthread.hpp"
#include "world.hpp"

namespace stator::board {

class RealWorld {
  public:
    // `truth` takes the true flight; may be null.
    RealWorld(const Conditions& conditions, std::FILE* truth);

    // Before it begins: puts motor controllers and a satellite receiver on a CAN bus. False if that
    // is not possible.
    [[nodiscard]] bool connect_can_parts(const char* interface);
    // After the graph has started. False if there is no thread for it.
    [[nodiscard]] bool begin();
    // Before the graph ends.
    void end();
    // What motors do from now on. Any one thread.
    void command_motors(const drivers::motor::sim::MotorSim::Control& control);
    // What devices without a line say now. Any thread.
    drivers::baro::sim::BaroSim::Device barometer();
    drivers::battery::sim::BatterySim::Device battery();

    // Once it has ended.
    const World& world() const { return world_; }
    bool truth_is_whole() const { return truth_is_whole_; }
    // Samples that were not read, as the driver was still busy with the one before.
    std::uint64_t missed_samples() const { return missed_samples_; }

  private:
    struct Command {
        std::uint64_t time_us;
        std::array<float, kRotors> control;
    };

    static constexpr unsigned kMaxCommands = 16;  // of one millisecond

    void run();
    void obey(std::uint64_t until_us);
    void serve_can(const World::Event& event);
    void hand_over(const World::Event& event, std::uint64_t now_us);
    bool can_take(const Line& line);

    World world_;
    std::FILE* truth_;
    bool truth_is_whole_ = false;
    std::uint64_t missed_samples_ = 0;
    pthread_t thread_{};
    std::atomic<bool> ends_{false};
    Mutex mutex_;
    std::array<Command, kMaxCommands> commands_{};  // under the mutex, and so is the next
    unsigned command_count_ = 0;
    CanParts can_parts_;
    drivers::baro::sim::BaroSim::Device barometer_{};
    drivers::battery::sim::BatterySim::Device battery_{};
};

}  // namespace stator::board
