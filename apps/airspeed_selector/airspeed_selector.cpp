// Airspeed and wind.
#include "airspeed_selector.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::airspeed_selector {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.2F;
constexpr float kFusionPeriod_s = 0.1F;
constexpr float kSeaLevelDensity = 1.225F;  // kg/m^3
constexpr float kAirConstant = 287.05F;     // J/(kg K)
constexpr float kKelvin = 273.15F;
// Parts are warmer than the air around the vehicle.
constexpr float kPartIsWarmer = 10.0F;  // K
constexpr float kGravity = 9.80665F;

float density_ratio(const AirspeedSelectorPorts& ports) {
    if (!ports.baro) return 1.0F;
    const float temperature = ports.baro->temperature - kPartIsWarmer + kKelvin;
    const float density = ports.baro->pressure / (kAirConstant * temperature);
    const float ratio = density / kSeaLevelDensity;
    return ratio > 0.2F && ratio < 1.5F ? ratio : 1.0F;
}

Vector3<float> velocity_of(const VehicleLocalPosition& p) {
    return {p.vx, p.vy, p.vz};
}

bool knows_velocity(const AirspeedSelectorPorts& ports) {
    return ports.position && ports.attitude && ports.position->v_xy_valid &&
           ports.position->v_z_valid && math::is_finite(velocity_of(*ports.position).sum());
}

}  // namespace

void AirspeedSelector::measure(const AirspeedSelectorPorts& ports) {
    tas_over_eas_ = 1.0F / math::sqrt(density_ratio(ports));
    pressure_ =
        ports.pressure ? ports.pressure->differential_pressure_pa - ports.params->offset : kNaN;
    const float raw = math::sqrt(2.0F * math::max(pressure_, 0.0F) / kSeaLevelDensity);
    equivalent_ = math::is_finite(pressure_) ? ports.params->scale * raw : kNaN;
}

void AirspeedSelector::fuse(const AirspeedSelectorPorts& ports, float dt) {
    if (!flies_ || !knows_velocity(ports)) return;
    const AirspeedSelectorParams& params = *ports.params;
    const Vector3<float> v_N = velocity_of(*ports.position);
    const auto q_NB = math::quaternion(ports.attitude->q);
    const float measured = check_.faults() == 0 ? equivalent_ * tas_over_eas_ : kNaN;
    if (!wind_.is_running()) {
        if (!(measured >= params.wind_speed_from)) return;
        wind_.start(v_N, math::heading(q_NB), measured);
        since_fusion_s_ = 0.0F;
    }
    wind_.predict(dt, params.wind_walk);
    const float expected = math::norm(wind_.air_N(v_N));
    innovation_ = equivalent_ * tas_over_eas_ - expected;
    since_fusion_s_ += dt;
    if (since_fusion_s_ < kFusionPeriod_s || expected < params.wind_speed_from) return;
    since_fusion_s_ = 0.0F;
    wind_.fuse_airspeed(v_N, measured, params.airspeed_noise, params.gate);
    wind_.fuse_sideslip(v_N, q_NB, params.sideslip_noise, params.gate);
}

void AirspeedSelector::check(const AirspeedSelectorPorts& ports, float dt) {
    if (!flies_) return;
    const AirspeedSelectorParams& params = *ports.params;
    float load = kNaN;
    if (ports.accel && math::is_finite(equivalent_)) {
        const float lift = math::abs(ports.accel->xyz[2]) / kGravity;
        load = lift * math::square(params.stall_airspeed / math::max(equivalent_, 0.1F));
    }
    check_.update({.is_new = ports.pressure.is_new(),
                   .pressure = pressure_,
                   .innovation = wind_.is_running() ? innovation_ : kNaN,
                   .load = load},
                  {.innovation = params.innovation_limit,
                   .innovation_integral = params.innovation_integral,
                   .load = params.load_limit},
                  dt);
}

void AirspeedSelector::step(AirspeedSelectorPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (armed && !was_armed_) {
        check_.reset();
        wind_.reset();
        innovation_ = kNaN;
    }
    was_armed_ = armed;
    flies_ = armed && ports.land && !ports.land->landed;
    measure(ports);
    fuse(ports, dt);
    check(ports, dt);

    const AirspeedSelectorParams& params = *ports.params;
    const float worst = math::max(wind_.variance_north(), wind_.variance_east());
    const bool knows_wind = wind_.is_running() && worst < math::square(params.wind_limit);
    AirspeedValidated result{
        .timestamp_sample = ports.pressure ? ports.pressure->timestamp_sample : ports.now,
        .indicated_airspeed_m_s = equivalent_,
        .calibrated_airspeed_m_s = kNaN,
        .true_airspeed_m_s = kNaN,
        .airspeed_source = AirspeedValidated::AirspeedSource::kNone,
        .faults = check_.faults()};
    if (check_.faults() == 0 && math::is_finite(equivalent_)) {
        result.airspeed_source = AirspeedValidated::AirspeedSource::kSensor;
        result.calibrated_airspeed_m_s = equivalent_;
        result.true_airspeed_m_s = equivalent_ * tas_over_eas_;
    } else if (knows_wind && knows_velocity(ports)) {
        result.airspeed_source = AirspeedValidated::AirspeedSource::kGroundMinusWind;
        result.true_airspeed_m_s = math::norm(wind_.air_N(velocity_of(*ports.position)));
        result.calibrated_airspeed_m_s = result.true_airspeed_m_s / tas_over_eas_;
    }
    ports.airspeed.publish([&] { return result; });
    ports.wind.publish([&] {
        return AirspeedWind{.windspeed_north = wind_.wind().x(),
                            .windspeed_east = wind_.wind().y(),
                            .variance_north = wind_.variance_north(),
                            .variance_east = wind_.variance_east(),
                            .tas_innov = innovation_,
                            .valid = knows_wind};
    });
}

}  // namespace stator::apps::airspeed_selector
