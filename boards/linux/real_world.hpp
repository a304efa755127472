// The simulated world in real time: a thread beside the graph's, in which every event of the world
// happens when its time has come.
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <cstdio>

#include "can_link.hpp"
#include "drivers/motor/sim/motor_sim.hpp"
#include "drivers/servo/sim/servo_sim.hpp"
#include "sensors.hpp"
#include "stator/mutex.hpp"
#include "stator/pthread.hpp"
#include "world/can_parts.hpp"
#include "world/world.hpp"

namespace stator::board {

class RealWorld {
  public:
    // `truth` takes the true flight; may be null.
    RealWorld(const world::Conditions& conditions, const world::Vehicle& vehicle, std::FILE* truth);

    // Before it begins: puts motor controllers and a satellite receiver on a CAN bus. False if that
    // is not possible.
    [[nodiscard]] bool connect_can_parts(const char* interface);
    // After the graph has started. False if there is no thread for it.
    [[nodiscard]] bool begin();
    // Before the graph ends.
    void end();
    // What motors do from now on. Any one thread.
    void command_motors(const drivers::motor::sim::MotorSim::Control& control);
    // The same of servos. Any one thread.
    void command_servos(const drivers::servo::sim::ServoSim::Control& control);

    // Once it has ended.
    const world::World& world() const { return world_; }
    bool truth_is_whole() const { return truth_is_whole_; }
    // Samples that were not read, as the driver was still busy with the one before.
    std::uint64_t missed_samples() const { return missed_samples_; }

  private:
    struct Command {
        std::uint64_t time_us;
        bool is_of_servos;
        world::Controls motors;
        world::ServoControls servos;
    };

    static constexpr unsigned kMaxCommands = 32;  // of one millisecond

    void run();
    void push(const Command& command);
    void obey(std::uint64_t until_us);
    void serve_can();
    void measure();

    struct Give;  // to one device

    world::World world_;
    Sensors sensors_;
    world::CanParts can_parts_;
    std::FILE* truth_;
    bool truth_is_whole_ = false;
    std::uint64_t missed_samples_ = 0;
    pthread_t thread_{};
    std::atomic<std::uint64_t> end_us_{UINT64_MAX};
    Mutex mutex_;
    std::array<Command, kMaxCommands> commands_{};  // under the mutex, and so is the next
    unsigned command_count_ = 0;
};

}  // namespace stator::board
