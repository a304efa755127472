// The simulated world of one flight.
#include "world/world.hpp"

#include <algorithm>
#include <string_view>

namespace stator::world {

namespace {

// What flies by a wing stands on a runway into the wind, or on a launcher.
constexpr double kMostOffRunway = 2.0 * math::kPi<double> / 180.0;

// Somewhere near the middle of the laboratory, the nose in any direction.
VehicleState draw_start(const Conditions& conditions, const Airframe& airframe) {
    math::Random random(conditions.seed, static_cast<std::uint64_t>(Stream::kStart));
    VehicleState start;
    start.position_N.x() = 0.4 * random.uniform_double() - 0.2;
    start.position_N.y() = 0.4 * random.uniform_double() - 0.2;
    const double part = random.uniform_double();
    if (!airframe.has_wing()) {
        const double yaw = math::kTwoPi<double> * part - math::kPi<double>;
        start.q_NB = math::from_euler(math::EulerAngles<double>{0.0, 0.0, yaw});
        return start;
    }
    const double yaw = math::wrap_pi(conditions.wind.from + kMostOffRunway * (2.0 * part - 1.0));
    double pitch = airframe.rest().pitch;
    if (conditions.launch != Launch::kGround) {
        const LaunchParameters launch = parameters_of(conditions.launch);
        start.position_N.z() = -launch.height;
        pitch = launch.pitch;
    }
    start.q_NB = math::from_euler(math::EulerAngles<double>{0.0, pitch, yaw});
    return start;
}

constexpr std::array<std::string_view, kMaxRotors> kMotors{
    "motor_1", "motor_2", "motor_3", "motor_4",  "motor_5",  "motor_6",
    "motor_7", "motor_8", "motor_9", "motor_10", "motor_11", "motor_12"};
constexpr std::array<std::string_view, kMaxSurfaces> kServos{
    "servo_1", "servo_2", "servo_3", "servo_4", "servo_5", "servo_6", "servo_7", "servo_8"};

}  // namespace

World::World(const Conditions& conditions, const Vehicle& published)
    : conditions_(conditions),
      vehicle_(conditions.vary ? vary(published, Variation{}, conditions.seed) : published),
      plant_(vehicle_.airframe, draw_start(conditions, vehicle_.airframe)),
      battery_(vehicle_.battery),
      wind_(conditions.wind, conditions.seed),
      launcher_(conditions.launch, math::heading(plant_.state().q_NB),
                vehicle_.airframe.has_wing()),
      watch_(plant_) {
    choose_air();
}

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
        plant_.command_servos(commands_.front().servos);
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
    const Vector3 more =
        faults.now(FaultKind::kWindSpeed, now_us).value_or(0.0) * wind_.direction();
    influence_.wind_N += more;
    influence_.supply = supply(now_us);
    influence_.current = battery_.current();
    choose_air();
    influence_.carried_N = launcher_.carries_N(plant_, motors_are_stopped_);
    plant_.block_wheels(motors_are_stopped_);
    for (unsigned i = 0; i < vehicle_.airframe.motor_count(); ++i) {
        const auto partial = faults.now(kMotors[i], FaultKind::kPartial, now_us);
        const bool is_lost = faults.now(kMotors[i], FaultKind::kLoss, now_us).has_value();
        influence_.efficiency[i] = is_lost ? 0.0 : partial.value_or(1.0);
    }
}

// A multicopter's rotors are described for the density at sea level; a wing flies in that of its
// height.
void World::choose_air() {
    if (!vehicle_.airframe.has_wing()) return;
    influence_.air_density = conditions_.earth.density(-plant_.state().position_N.z());
}

// The voltage that the motors get, of the nominal one.
double World::supply(std::uint64_t now_us) {
    const Faults& faults = conditions_.faults;
    if (faults.now(FaultKind::kDead, now_us)) return 0.0;
    double voltage = battery_.voltage() * faults.now(FaultKind::kSag, now_us).value_or(1.0);
    // It holds the current near what it can give by giving less voltage.
    const auto most = faults.now(FaultKind::kWeakSupply, now_us);
    constexpr double kFalls = 0.995;
    constexpr double kRises = 1.002;
    const bool is_over = most && battery_.current() > *most;
    weakness_ = most ? math::min(weakness_ * (is_over ? kFalls : kRises), 1.0) : 1.0;
    voltage *= weakness_;
    return voltage / plant_.parameters().nominal_voltage;
}

bool World::has_fault(FaultKind kind) const {
    return conditions_.faults.now(kind, time_us()).has_value();
}

void World::command_motors(std::uint64_t now_us, const Controls& control) {
    for (unsigned i = 0; i < kMaxRotors; ++i) {
        const bool is_stuck =
            conditions_.faults.now(kMotors[i], FaultKind::kMotorStuck, now_us).has_value();
        if (!is_stuck) obeyed_[i] = control[i];
    }
    motors_are_stopped_ = std::all_of(control.begin(), control.end(), math::is_nan<float>);
    push_command(now_us);
}

void World::command_servos(std::uint64_t now_us, const ServoControls& control) {
    for (unsigned i = 0; i < kMaxSurfaces; ++i) {
        const auto has = [&](FaultKind kind) {
            return conditions_.faults.now(kServos[i], kind, now_us).has_value();
        };
        if (has(FaultKind::kLoss)) {
            obeyed_servos_[i] = 0.0F;  // a linkage that has come off, in the wind
        } else if (!has(FaultKind::kStuck)) {
            obeyed_servos_[i] = control[i];
        }
    }
    push_command(now_us);
}

void World::push_command(std::uint64_t now_us) {
    commands_.push_back({now_us + vehicle_.command_delay_us, obeyed_, obeyed_servos_});
    move_plant(now_us);
}

}  // namespace stator::world
