// A receiver of satellite navigation on a CAN bus.
#include "can_gnss.hpp"

#include <algorithm>
#include <cstddef>

#include "stator/dronecan/field.hpp"
#include "stator/dronecan/port.hpp"
#include "stator/math/quotient.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::can_gnss {

namespace {

using Fix = CanGnss::Fix;
using Geometry = CanGnss::Geometry;

constexpr uint64_t kSilence_us = 3'000'000;
// 25 fixes a second of at most 32 frames; geometry of 3 frames with each.
constexpr std::array kWanted{dronecan::want<Fix>(800), dronecan::want<Geometry>(100)};
constexpr unsigned kDiagonal = 6;
constexpr unsigned kWhole = 36;
constexpr int32_t kDegree = 100'000'000;  // in the fix's unit
constexpr int32_t kMetre = 1000;

bool has_position(const Fix& fix) {
    return fix.status == Fix::kStatus2dFix || fix.status == Fix::kStatus3dFix;
}

bool is_plausible(const Fix& fix) {
    constexpr float kFastest = 1000.0F;  // m/s
    bool good = fix.latitude_deg_1e8 >= int64_t{-90} * kDegree &&
                fix.latitude_deg_1e8 <= int64_t{90} * kDegree &&
                fix.longitude_deg_1e8 >= int64_t{-180} * kDegree &&
                fix.longitude_deg_1e8 <= int64_t{180} * kDegree &&
                fix.height_msl_mm >= -1000 * kMetre && fix.height_msl_mm <= 60'000 * kMetre;
    for (const float v : fix.ned_velocity) {
        good = good && dronecan::is_possible(v, -kFastest, kFastest);
    }
    for (const float v : fix.covariance.view()) {
        good = good && dronecan::is_possible(v, -65504.0F, 65504.0F);
    }
    return good;
}

// Of component `index` of north, east, down position and velocity; NaN if unknown, which some
// receivers say with a negative number.
float variance(const Fix& fix, std::size_t index) {
    float value = math::canonical_nan<float>();
    if (fix.covariance.count == kDiagonal) value = fix.covariance.items[index];
    if (fix.covariance.count == kWhole) value = fix.covariance.items[(kDiagonal + 1) * index];
    return value >= 0.0F ? value : math::canonical_nan<float>();
}

bool has_velocity(const Fix& fix) {
    return has_position(fix) && !std::ranges::any_of(fix.ned_velocity, math::is_nan<float>);
}

SensorGps::FixType fix_type(const Fix& fix) {
    using Type = SensorGps::FixType;
    if (!has_position(fix)) return Type::kNone;
    if (fix.mode == Fix::kModeRtk) {
        return fix.sub_mode == Fix::kSubModeRtkFixed ? Type::kRtkFixed : Type::kRtkFloat;
    }
    if (fix.mode == Fix::kModeDgps) return Type::kRtcmCodeDifferential;
    return fix.status == Fix::kStatus2dFix ? Type::kFix2d : Type::kFix3d;
}

}  // namespace

CanGnss::CanGnss() : receiver_(kWanted) {}

void CanGnss::configure(const CanGnssParams& params) {
    dronecan::NodeSet nodes;
    nodes.add_range(params.first_node, params.last_node);
    receiver_.allow(nodes);
}

bool CanGnss::is_ours(uint64_t now_us) {
    const uint8_t source = receiver_.header().source;
    if (node_ != source && node_ != 0 && now_us - heard_us_ <= kSilence_us) return false;
    node_ = source;
    heard_us_ = now_us;
    return true;
}

void CanGnss::take_geometry(uint64_t now_us) {
    Geometry geometry;
    if (!dronecan::decode(receiver_.payload(), geometry) ||
        !dronecan::is_possible(geometry.hdop, 0.0F, 1000.0F) ||
        !dronecan::is_possible(geometry.vdop, 0.0F, 1000.0F)) {
        receiver_.count_undecodable();
        return;
    }
    geometry_ = geometry;
    geometry_us_ = now_us;
}

SensorGps CanGnss::sample(const Fix& fix, const CanGnssParams& params) const {
    const auto latency_us = math::saturate<uint32_t>(params.latency * 1e6F);
    float horizontal = math::sqrt(0.5F * (variance(fix, 0) + variance(fix, 1)));
    float vertical = math::sqrt(variance(fix, 2));
    if (geometry_us_ != 0 && receiver_.begun_us() <= geometry_us_ + kSilence_us) {
        if (math::is_nan(horizontal)) horizontal = geometry_.hdop * params.range_error;
        if (math::is_nan(vertical)) vertical = geometry_.vdop * params.range_error;
    }
    return {.timestamp_sample =
                receiver_.begun_us() > latency_us ? receiver_.begun_us() - latency_us : 0,
            .latitude_deg = math::quotient(fix.latitude_deg_1e8, kDegree),
            .longitude_deg = math::quotient(fix.longitude_deg_1e8, kDegree),
            .altitude_msl_m = math::quotient(fix.height_msl_mm, kMetre),
            .altitude_ellipsoid_m = math::quotient(fix.height_ellipsoid_mm, kMetre),
            .s_variance_m_s = math::sqrt(variance(fix, 3)),
            .eph = horizontal,
            .epv = vertical,
            .vel_n_m_s = fix.ned_velocity[0],
            .vel_e_m_s = fix.ned_velocity[1],
            .vel_d_m_s = fix.ned_velocity[2],
            .fix_type = fix_type(fix),
            .vel_ned_valid = has_velocity(fix),
            .satellites_used = fix.sats_used};
}

void CanGnss::take_fix(CanGnssPorts& ports) {
    Fix fix;
    if (!dronecan::decode(receiver_.payload(), fix) || !is_plausible(fix)) {
        receiver_.count_undecodable();
        return;
    }
    ports.position.publish([&] { return sample(fix, *ports.params); });
}

void CanGnss::receive(CanGnssPorts& ports) {
    const CanFrame& received = *ports.can;
    dronecan::Frame frame;
    if (!dronecan::from_topic(received, frame)) return;
    if (!receiver_.accept(frame, received.timestamp) || !is_ours(received.timestamp)) return;
    if (receiver_.is<Fix>()) {
        take_fix(ports);
    } else {
        take_geometry(received.timestamp);
    }
}

void CanGnss::step(CanGnssPorts& ports) {
    if (ports.params.is_new()) configure(*ports.params);
    while (ports.can.next()) receive(ports);
}

}  // namespace stator::apps::can_gnss
