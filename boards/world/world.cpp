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
      imu_(vehicle_.imu, conditions.seed),
      mocap_(mocap_parameters_, conditions.seed),
      magnetometer_(vehicle_.magnetometer, conditions.earth, conditions.seed),
      barometer_(vehicle_.barometer, conditions.earth, conditions.seed),
      gnss_(gnss_parameters_, conditions.earth, conditions.seed),
      watch_(plant_) {}

World::Event World::move_to_next_event() {
    const std::uint64_t now_us = next_event_us();
    move_plant(now_us);
    Event event;
    imu_timer_.take(now_us);
    event.imu = imu_.measure(plant_);
    watch_.see(plant_, motors_are_stopped_);
    event.mocap = watch_with_cameras(now_us);
    if (magnetometer_timer_.take(now_us)) {
        event.mag_B = magnetometer_.measure(plant_.state(), battery_.current());
    }
    const bool has_baro = !conditions_.faults.now(FaultKind::kBaroLoss, now_us);
    if (barometer_timer_.take(now_us) && has_baro) event.baro = barometer_.measure(plant_);
    event.gnss = listen_to_satellites(now_us);
    if (radio_timer_.take(now_us)) event.radio = listen_to_pilot(now_us);
    influence_plant(now_us);
    event.battery_measured = battery_timer_.take(now_us);
    return event;
}

void World::move_plant(std::uint64_t time_us) {
    while (!commands_.empty() && commands_.front().time_us <= time_us) {
        plant_.run_until(commands_.front().time_us);
        plant_.command(commands_.front().control);
        commands_.pop_front();
    }
    plant_.run_until(time_us);
}

// What acts on the vehicle from outside, until the next event.
void World::influence_plant(std::uint64_t now_us) {
    const Faults& faults = conditions_.faults;
    battery_.draw(plant_.electric_power(), static_cast<double>(vehicle_.imu.period_us) * 1e-6);
    if (const auto left = faults.now(FaultKind::kBatteryLow, now_us)) battery_.limit(*left);
    const double height = -plant_.state().position_N.z();
    Influence influence;
    influence.wind_N = wind_.at(now_us, height, math::norm(plant_.velocity_in_air_B()));
    influence.supply = battery_.voltage() / plant_.parameters().nominal_voltage;
    for (unsigned i = 0; i < kRotors; ++i) {
        influence.efficiency[i] = faults.now(kMotorFaults[i], now_us).value_or(1.0);
    }
    plant_.set_influence(influence);
}

std::optional<MocapSample> World::watch_with_cameras(std::uint64_t now_us) {
    std::optional<MocapSample> arrived;
    if (arrival_timer_.take(now_us)) arrived = picture_;
    if (picture_timer_.take(now_us)) picture_ = mocap_.measure(plant_);
    return arrived;
}

std::optional<GnssFix> World::listen_to_satellites(std::uint64_t now_us) {
    std::optional<GnssFix> arrived;
    if (sending_ && now_us >= sending_->arrival_us) {
        if (sending_->arrives) arrived = sending_->fix;
        sending_.reset();
    }
    if (fix_timer_.take(now_us)) {
        const Faults& faults = conditions_.faults;
        sending_ = gnss_.measure(
            plant_, {.lost = faults.now(FaultKind::kGnssLoss, now_us).has_value(),
                     .glitch = faults.now(FaultKind::kGnssGlitch, now_us).value_or(0.0)});
    }
    return arrived;
}

const World::RadioFrame& World::listen_to_pilot(std::uint64_t now_us) {
    radio_.is_heard = !conditions_.faults.now(FaultKind::kRcLoss, now_us);
    if (radio_.is_heard) radio_.hands = conditions_.pilot.frame(now_us);
    return radio_;
}

bool World::mission_is_lost() const {
    return conditions_.faults.now(FaultKind::kMissionLoss, plant_.time_us()).has_value();
}

void World::command_motors(std::uint64_t now_us, const std::array<float, kRotors>& control) {
    commands_.push_back({now_us + vehicle_.command_delay_us, control});
    move_plant(now_us);
    motors_are_stopped_ = std::all_of(control.begin(), control.end(), math::is_nan<float>);
}

}  // namespace stator::world
