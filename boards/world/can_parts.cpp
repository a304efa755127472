// What is on the simulated CAN bus beside the vehicle.
#include "world/can_parts.hpp"

#include "dronecan/equipment/esc/status.hpp"
#include "dronecan/equipment/gnss/auxiliary.hpp"
#include "dronecan/equipment/gnss/fix2.hpp"
#include "dronecan/protocol/node_status.hpp"

namespace stator::world {

namespace {

using dronecan::equipment::esc::RawCommand;
using dronecan::equipment::esc::Status;
using dronecan::equipment::gnss::Auxiliary;
using dronecan::equipment::gnss::Fix2;
using dronecan::protocol::NodeStatus;

// Parts: the controllers, then the receiver.
constexpr unsigned kReceiver = kMaxRotors;
constexpr std::uint8_t kFirstController = 20;
constexpr std::uint8_t kReceiverId = 40;
constexpr std::uint64_t kCommandTimeout_us = 500'000;
constexpr float kFull = 8191.0F;
constexpr std::array kWanted{dronecan::want<RawCommand>(10'000)};

std::uint8_t node_id(unsigned part) {
    return part == kReceiver ? kReceiverId : static_cast<std::uint8_t>(kFirstController + part);
}

std::int64_t hundred_millionths(double degrees) {
    return math::saturate<std::int64_t>(math::round(degrees * 1e8));
}
std::int32_t millimetres(double metres) {
    return math::saturate<std::int32_t>(math::round(metres * 1e3));
}

}  // namespace

CanParts::CanParts(const World& world, Send sink)
    : send_(sink),
      rotors_(world.vehicle().airframe.rotor_count()),
      gnss_(world),
      receiver_(kWanted) {
    dronecan::NodeSet all;
    all.add_range(1, dronecan::kMaxNodeId);
    receiver_.allow(all);
}

std::optional<CanParts::Control> CanParts::receive(const dronecan::Frame& frame,
                                                   std::uint64_t now_us) {
    awake_ = true;
    RawCommand command;
    if (!receiver_.accept(frame, now_us) || !dronecan::decode(receiver_.payload(), command)) {
        return std::nullopt;
    }
    for (unsigned i = 0; i < kMaxRotors; ++i) {
        const bool turns = i < command.cmd.count && command.cmd.items[i] > 0;
        control_[i] =
            turns ? static_cast<float>(command.cmd.items[i]) / kFull : math::canonical_nan<float>();
    }
    commanded_us_ = now_us;
    commanded_ = true;
    return control_;
}

bool CanParts::times_out(std::uint64_t now_us) {
    if (!commanded_ || now_us - commanded_us_ < kCommandTimeout_us) return false;
    commanded_ = false;
    control_.fill(math::canonical_nan<float>());
    return true;
}

template <class Message>
void CanParts::send(const Message& message, unsigned part, std::uint8_t& transfer_id,
                    std::uint64_t now_us) {
    dronecan::Sender<Message::kType.most_bytes> sender;
    sender.begin({.priority = 16, .source = node_id(part)}, transfer_id, message);
    transfer_id = static_cast<std::uint8_t>((transfer_id + 1) % dronecan::kTransferIds);
    for (dronecan::Frame frame; sender.next(frame);) {
        send_(frame, now_us);
    }
}

void CanParts::report(const World& world, unsigned motor) {
    constexpr double kRpm = 30.0 / math::kPi<double>;  // in 1 rad/s
    const double speed = world.plant().state().rotor_speeds[motor];
    const float control = math::is_nan(control_[motor]) ? 0.0F : control_[motor];
    const Status status{
        .voltage = static_cast<float>(world.battery().voltage()),
        .current = static_cast<float>(world.battery().current() / rotors_),
        .temperature = 313.15F,  // 40 degC, always
        .rpm = math::saturate<std::int32_t>(math::round(speed * kRpm)),
        .power_rating_pct = math::saturate<std::uint8_t>(math::round(100.0F * control)),
        .esc_index = static_cast<std::uint8_t>(motor)};
    send(status, motor, report_ids_[motor], world.plant().time_us());
}

void CanParts::send_fix(const GnssFix& fix, std::uint64_t now_us) {
    const bool has_fix = fix.satellites >= 4;
    Fix2 message{.longitude_deg_1e8 = hundred_millionths(fix.place.longitude_deg),
                 .latitude_deg_1e8 = hundred_millionths(fix.place.latitude_deg),
                 .height_ellipsoid_mm = millimetres(fix.place.altitude_ellipsoid),
                 .height_msl_mm = millimetres(fix.place.altitude_msl),
                 .ned_velocity = math::to_array(fix.velocity_N),
                 .sats_used = static_cast<std::uint8_t>(fix.satellites),
                 .status = has_fix ? Fix2::kStatus3dFix : Fix2::kStatusNoFix};
    const float horizontal = math::square(fix.horizontal_error);
    const float speed = math::square(fix.speed_error);
    message.covariance.assign(
        std::array{horizontal, horizontal, math::square(fix.vertical_error), speed, speed, speed});
    send(message, kReceiver, fix_id_, now_us);
    const Auxiliary geometry{.pdop = 1.5F,
                             .hdop = 0.8F,
                             .vdop = 1.2F,
                             .sats_visible = static_cast<std::uint8_t>(fix.satellites),
                             .sats_used = static_cast<std::uint8_t>(fix.satellites)};
    send(geometry, kReceiver, geometry_id_, now_us);
}

void CanParts::run(const World& world) {
    const std::optional<GnssFix> fix = gnss_.receive(world);
    if (!awake_) return;
    const std::uint64_t now_us = world.plant().time_us();
    if (fix) send_fix(*fix, now_us);
    if (report_timer_.take(now_us)) {
        for (unsigned i = 0; i < rotors_; ++i) report(world, i);
    }
    if (!status_timer_.take(now_us)) return;
    const NodeStatus status{.uptime_sec = static_cast<std::uint32_t>(now_us / 1'000'000)};
    for (unsigned part = 0; part < rotors_; ++part) send(status, part, status_ids_[part], now_us);
    send(status, kReceiver, status_ids_[kReceiver], now_us);
}

}  // namespace stator::world
