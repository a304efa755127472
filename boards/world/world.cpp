// The simulated world of one flight.
#include "world/world.hpp"

#include <algorithm>

namespace stator::world {

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

constexpr std::array kMotorFaults{FaultKind::kMotor1, FaultKind::kMotor2, FaultKind::kMotor3,
                                  FaultKind::kMotor4};

}  // namespace

World::World(const Conditions& conditions)
    : conditions_(conditions),
      vehicle_(conditions.vary ? vary(Variation{}, conditions.seed) : Vehicle{}),
      plant_(vehicle_.quad, draw_start(conditions.seed)),
      wind_(conditions.wind, conditions.seed),
      watch_(plant_) {}

void World::move_to_next_event() {
    const std::uint64_t now_us = next_event_us_;
    next_event_us_ += kStep_us;
    move_plant(now_us);
    watch_.see(plant_, motors_are_stopped_);
    choose_influence(now_us);
}

void World::move_plant(std::uint64_t time_us) {
    plant_.set_influence(influence_);
    while (!commands_.empty() && commands_.front().time_us <= time_us) {
        plant_.run_until(commands_.front().time_us);
        plant_.command(commands_.front().control);
        commands_.pop_front();
    }
    plant_.run_until(time_us);
}

// What acts on the vehicle from outside, until the next event.
void World::choose_influence(std::uint64_t now_us) {
    const Faults& faults = conditions_.faults;
    battery_.draw(plant_.electric_power(), static_cast<double>(kStep_us) * 1e-6);
    if (const auto left = faults.now(FaultKind::kBatteryLow, now_us)) battery_.limit(*left);
    const double height = -plant_.state().position_N.z();
    influence_.wind_N = wind_.at(now_us, height, math::norm(plant_.velocity_in_air_B()));
    influence_.supply = battery_.voltage() / plant_.parameters().nominal_voltage;
    influence_.current = battery_.current();
    for (unsigned i = 0; i < kRotors; ++i) {
        influence_.efficiency[i] = faults.now(kMotorFaults[i], now_us).value_or(1.0);
    }
}

bool World::has_fault(FaultKind kind) const {
    return conditions_.faults.now(kind, time_us()).has_value();
}

void World::command_motors(std::uint64_t now_us, const std::array<float, kRotors>& control) {
    commands_.push_back({now_us + vehicle_.command_delay_us, control});
    move_plant(now_us);
    motors_are_stopped_ = std::all_of(control.begin(), control.end(), math::is_nan<float>);
}

}  // namespace stator::world
