// The simulated world in real time.
#include "real_world.hpp"

#include <algorithm>

#include "hand_over.hpp"
#include "world/truth.hpp"

namespace stator::board {

namespace {

// Of the one world of a process; its thread alone uses it.
CanLink can_link;

}  // namespace

RealWorld::RealWorld(const world::Conditions& conditions, const world::Vehicle& vehicle,
                     std::FILE* truth)
    : world_(conditions, vehicle),
      sensors_(world_),
      can_parts_(world_, [](const dronecan::Frame& frame, std::uint64_t) { can_link.send(frame); }),
      truth_(truth) {}

bool RealWorld::connect_can_parts(const char* interface) {
    return can_link.open(interface);
}

// What the vehicle sent since the last event acts from now on.
void RealWorld::serve_can() {
    const std::uint64_t now_us = world_.time_us();
    for (dronecan::Frame frame; can_link.receive(frame);) {
        const auto control = can_parts_.receive(frame, now_us);
        if (control) world_.command_motors(now_us, *control);
    }
    can_parts_.run(world_);
    if (can_parts_.times_out(now_us)) {
        world::CanParts::Control stopped;
        stopped.fill(math::canonical_nan<float>());
        world_.command_motors(now_us, stopped);
    }
}

bool RealWorld::begin() {
    truth_is_whole_ = truth_ == nullptr || world::write_truth_head(truth_, world_);
    const auto run = [](void* object) { static_cast<RealWorld*>(object)->run(); };
    return make_device_thread(thread_, "world", run, this);
}

void RealWorld::end() {
    end_us_.store(clock_us());
    pthread_join(thread_, nullptr);
}

void RealWorld::run() {
    bool was_over = false;
    while (true) {
        const std::uint64_t event_us = world_.next_event_us();
        sleep_until_us(event_us);
        if (event_us > end_us_.load()) return;  // all that was due by then happens
        obey(event_us);
        world_.move_to_next_event();
        measure();
        if (can_link.is_open()) serve_can();
        if (truth_ != nullptr && event_us % world::kTruthPeriod_us == 0) {
            truth_is_whole_ = world::write_truth(truth_, world_) && truth_is_whole_;
        }
        if (world_.is_over() && !was_over) stop();
        was_over = world_.is_over();
    }
}

void RealWorld::command_motors(const drivers::motor::sim::MotorSim::Control& control) {
    push({.time_us = clock_us(), .is_of_servos = false, .motors = control, .servos = {}});
}

void RealWorld::command_servos(const drivers::servo::sim::ServoSim::Control& control) {
    push({.time_us = clock_us(), .is_of_servos = true, .motors = {}, .servos = control});
}

void RealWorld::push(const Command& command) {
    const Lock lock(&mutex_);
    // A world that is held up that long sees the newest command all the same.
    if (command_count_ == kMaxCommands) --command_count_;
    commands_[command_count_++] = command;
}

// Commands act at their own times, in order; one that was held up on its way acts now.
void RealWorld::obey(std::uint64_t until_us) {
    const Lock lock(&mutex_);
    unsigned done = 0;
    for (; done < command_count_ && commands_[done].time_us <= until_us; ++done) {
        const Command& command = commands_[done];
        const std::uint64_t time_us = std::max(command.time_us, world_.time_us());
        if (command.is_of_servos) {
            world_.command_servos(time_us, command.servos);
        } else {
            world_.command_motors(time_us, command.motors);
        }
    }
    std::move(commands_.begin() + done, commands_.begin() + command_count_, commands_.begin());
    command_count_ -= done;
}

// A device whose driver is still busy with the sample before does not take the new one.
struct RealWorld::Give {
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample, Line& line) const {
        if (!line.is_served()) {
            ++missed_samples;
            return;
        }
        device = sample;
        line.raise();
    }
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample) const {
        device.put(sample);
    }
    std::uint64_t& missed_samples;
};

void RealWorld::measure() {
    Samples samples;
    sensors_.measure(world_, samples);
    hand_over(samples, Give{missed_samples_});
}

}  // namespace stator::board
