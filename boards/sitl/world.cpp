// The simulated world of one flight.
#include "world.hpp"

#include <algorithm>

namespace stator::board {

namespace {

// Somewhere near the middle of the laboratory, the nose in any direction.
QuadState draw_start(std::uint64_t seed) {
    math::Random random(seed, static_cast<std::uint64_t>(Stream::kStart));
    QuadState start;
    start.position_N.x() = 0.4 * random.uniform_double() - 0.2;
    start.position_N.y() = 0.4 * random.uniform_double() - 0.2;
    const double yaw = math::kTwoPi<double> * random.uniform_double() - math::kPi<double>;
    start.q_NB = math::from_euler(math::EulerAngles<double>{0.0, 0.0, yaw});
    return start;
}

}  // namespace

World::World(std::uint64_t seed)
    : plant_(QuadParameters{}, draw_start(seed)),
      imu_(imu_parameters_, seed),
      mocap_(mocap_parameters_, seed),
      watch_(plant_),
      next_arrival_us_(mocap_parameters_.delay_us) {}

std::uint64_t World::next_event_us() const {
    return std::min({next_imu_us_, next_picture_us_, next_arrival_us_});
}

World::Event World::move_to_next_event() {
    const std::uint64_t now_us = next_event_us();
    plant_.run_until(now_us);
    Event event;
    if (now_us == next_imu_us_) {
        next_imu_us_ += imu_parameters_.period_us;
        event.imu_sampled = true;
        event.imu = imu_.measure(plant_);
        watch_.see(plant_, motors_are_stopped_);
    }
    if (now_us == next_arrival_us_) {
        next_arrival_us_ += mocap_parameters_.period_us;
        event.mocap_received = true;
        event.mocap = on_its_way_;
    }
    if (now_us == next_picture_us_) {
        next_picture_us_ += mocap_parameters_.period_us;
        on_its_way_ = mocap_.measure(plant_);
    }
    return event;
}

void World::command_motors(std::uint64_t now_us, const std::array<float, kRotors>& control) {
    plant_.run_until(now_us);
    plant_.command(control);
    motors_are_stopped_ = std::all_of(control.begin(), control.end(), math::is_nan<float>);
}

}  // namespace stator::board
