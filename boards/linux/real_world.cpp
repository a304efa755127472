// The simulated world in real time.
#include "real_world.hpp"

#include <algorithm>

#include "board.hpp"
#include "fill.hpp"
#include "truth.hpp"

namespace stator::board {

namespace {

// Of the one world of a process; its thread alone uses it.
CanLink can_link;

}  // namespace

RealWorld::RealWorld(const Conditions& conditions, std::FILE* truth)
    : world_(conditions),
      truth_(truth),
      can_parts_([](const dronecan::Frame& frame, std::uint64_t) { can_link.send(frame); }) {}

bool RealWorld::connect_can_parts(const char* interface) {
    return can_link.open(interface);
}

// What the vehicle sent since the last event acts from now on.
void RealWorld::serve_can(const World::Event& event) {
    const std::uint64_t now_us = world_.plant().time_us();
    for (dronecan::Frame frame; can_link.receive(frame);) {
        const auto control = can_parts_.receive(frame, now_us);
        if (control) world_.command_motors(now_us, *control);
    }
    can_parts_.run(world_, event.gnss);
    if (can_parts_.times_out(now_us)) {
        CanParts::Control stopped;
        stopped.fill(math::canonical_nan<float>());
        world_.command_motors(now_us, stopped);
    }
}

bool RealWorld::begin() {
    truth_is_whole_ = truth_ == nullptr || write_truth_head(truth_);
    const auto run = [](void* object) { static_cast<RealWorld*>(object)->run(); };
    return make_device_thread(thread_, "world", run, this);
}

void RealWorld::end() {
    ends_.store(true);
    pthread_join(thread_, nullptr);
}

void RealWorld::run() {
    bool was_over = false;
    while (true) {
        const std::uint64_t event_us = world_.next_event_us();
        sleep_until_us(event_us);
        if (ends_.load()) return;
        obey(event_us);
        const World::Event event = world_.move_to_next_event();
        hand_over(event, event_us);
        if (can_link.is_open()) serve_can(event);
        if (truth_ != nullptr && event_us % kTruthPeriod_us == 0) {
            truth_is_whole_ = write_truth(truth_, world_) && truth_is_whole_;
        }
        if (world_.is_over() && !was_over) stop();
        was_over = world_.is_over();
    }
}

void RealWorld::command_motors(const drivers::motor::sim::MotorSim::Control& control) {
    const Command command{clock_us(), {control[0], control[1], control[2], control[3]}};
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
        world_.command_motors(std::max(commands_[done].time_us, world_.plant().time_us()),
                              commands_[done].control);
    }
    std::move(commands_.begin() + done, commands_.begin() + command_count_, commands_.begin());
    command_count_ -= done;
}

bool RealWorld::can_take(const Line& line) {
    if (line.is_served()) return true;
    ++missed_samples_;
    return false;
}

drivers::baro::sim::BaroSim::Device RealWorld::barometer() {
    const Lock lock(&mutex_);
    return barometer_;
}

drivers::battery::sim::BatterySim::Device RealWorld::battery() {
    const Lock lock(&mutex_);
    return battery_;
}

void RealWorld::hand_over(const World::Event& event, std::uint64_t now_us) {
    if (event.imu && can_take(imu0_data_ready)) {
        imu0 = {.timestamp_sample = now_us,
                .gyro_B = math::to_array(event.imu->gyro_B),
                .accel_B = math::to_array(event.imu->accel_B)};
        imu0_data_ready.raise();
    }
    if (event.mocap && can_take(mocap0_received)) {
        mocap0 = {.timestamp_sample = event.mocap->time_us,
                  .position_N = math::to_array(event.mocap->position_N),
                  .yaw = event.mocap->yaw};
        mocap0_received.raise();
    }
    if (event.mag_B && can_take(mag0_data_ready)) {
        mag0 = {.timestamp_sample = now_us, .field_B_gauss = math::to_array(*event.mag_B)};
        mag0_data_ready.raise();
    }
    if (event.gnss && can_take(gnss0_received)) {
        fill(gnss0, *event.gnss);
        gnss0_received.raise();
    }
    if (event.radio && can_take(radio0_received)) {
        fill(radio0, *event.radio, now_us);
        radio0_received.raise();
    }
    const Lock lock(&mutex_);
    if (event.baro) fill(barometer_, *event.baro, now_us);
    fill(battery_, world_.battery());
}

}  // namespace stator::board
