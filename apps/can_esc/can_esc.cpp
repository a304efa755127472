// Motor controllers on a CAN bus.
#include "can_esc.hpp"

#include <algorithm>

#include "stator/dronecan/field.hpp"
#include "stator/dronecan/port.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::can_esc {

namespace {

using dronecan::equipment::esc::RawCommand;
using dronecan::equipment::esc::Status;
using dronecan::equipment::safety::ArmingStatus;

constexpr uint8_t kCommandPriority = 4;  // of 31; nothing on the bus is more urgent
constexpr uint8_t kArmingPriority = 20;
constexpr uint64_t kReportPeriod_us = 100'000;
constexpr uint64_t kStopPeriod_us = 20'000;  // controllers stop by themselves after some 0.5 s
constexpr float kFull = 8191.0F;             // of a command
constexpr float kZeroCelsius = 273.15F;
// 100 reports a second of 3 frames each: twice what the fastest controllers send.
constexpr std::array kWanted{dronecan::want<Status>(300)};

// Stopped is 0; whatever turns gets at least the least command.
int16_t raw_command(float control) {
    if (math::is_nan(control)) return 0;
    return math::saturate<int16_t>(math::round(math::clamp(control * kFull, 1.0F, kFull)));
}

}  // namespace

CanEsc::CanEsc() : receiver_(kWanted) {}

void CanEsc::configure(const CanEscParams& params) {
    dronecan::NodeSet nodes;
    nodes.add_range(params.first_node, params.last_node);
    receiver_.allow(nodes);
    node_id_ = static_cast<uint8_t>(params.node_id);
    count_ = static_cast<unsigned>(std::clamp<int32_t>(params.esc_count, 1, kMaxEscs));
    offline_timeout_us_ = math::saturate<uint32_t>(params.offline_timeout * 1e6F);
    interval_us_ = static_cast<uint64_t>(std::max<int32_t>(params.command_interval, 1));
}

bool CanEsc::is_online(const Esc& esc, uint64_t now_us) const {
    // A frame may be newer than the release whose activation reads it.
    return esc.node != 0 && now_us <= esc.heard_us + offline_timeout_us_;
}

// Limits of anything that flies; and a controller speaks for itself only. What it does not measure
// is NaN, here and in the report.
bool CanEsc::is_plausible(const Report& report, uint64_t now_us) const {
    if (report.esc_index >= count_) return false;
    const Esc& esc = escs_[report.esc_index];
    if (is_online(esc, now_us) && esc.node != receiver_.header().source) return false;
    return dronecan::is_possible(report.voltage, 0.0F, 200.0F) &&
           dronecan::is_possible(report.current, -1000.0F, 1000.0F) &&
           dronecan::is_possible(report.temperature, 0.0F, 1000.0F);
}

void CanEsc::receive(const CanFrame& received) {
    const uint64_t now_us = received.timestamp;
    dronecan::Frame frame;
    if (!dronecan::from_topic(received, frame) || !receiver_.accept(frame, now_us)) return;
    Report report;
    if (!dronecan::decode(receiver_.payload(), report) || !is_plausible(report, now_us)) {
        receiver_.count_undecodable();
        return;
    }
    escs_[report.esc_index] = {
        .report = report, .heard_us = now_us, .node = receiver_.header().source};
}

template <class Message>
void CanEsc::send(CanEscPorts& ports, const Message& message, uint8_t priority,
                  uint8_t& transfer_id, uint64_t timestamp_sample) {
    dronecan::Sender<Message::kType.most_bytes> sender;
    sender.begin({.priority = priority, .source = node_id_}, transfer_id, message);
    transfer_id = static_cast<uint8_t>((transfer_id + 1) % dronecan::kTransferIds);
    for (dronecan::Frame frame; sender.next(frame);) {
        ports.frames.publish([&] { return dronecan::to_topic<CanFrame>(frame, timestamp_sample); });
    }
}

void CanEsc::command(CanEscPorts& ports) {
    RawCommand command;
    command.cmd.count = static_cast<uint16_t>(count_);
    for (unsigned i = 0; i < count_ && ports.motors; ++i) {
        command.cmd.items[i] = raw_command(ports.motors->control[i]);
    }
    send(ports, command, kCommandPriority, command_id_,
         ports.motors ? ports.motors->timestamp_sample : 0);
}

void CanEsc::announce_arming(CanEscPorts& ports) {
    if (!ports.status) return;
    const bool armed = ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    const ArmingStatus status{.status = armed ? ArmingStatus::kStatusFullyArmed
                                              : ArmingStatus::kStatusDisarmed};
    send(ports, status, kArmingPriority, arming_id_, ports.status->timestamp);
}

EscStatus CanEsc::report(uint64_t now_us) {
    EscStatus result{.counter = ++reports_,
                     .esc_count = static_cast<uint8_t>(count_),
                     .rejected = receiver_.counters().rejected()};
    for (unsigned i = 0; i < count_; ++i) {
        const Esc& esc = escs_[i];
        if (!is_online(esc, now_us)) continue;
        result.esc_online_flags = static_cast<uint16_t>(result.esc_online_flags | (1U << i));
        result.esc_address[i] = esc.node;
        result.esc_power[i] = esc.report.power_rating_pct;
        result.esc_errorcount[i] = esc.report.error_count;
        result.esc_rpm[i] = esc.report.rpm;
        result.esc_voltage[i] = esc.report.voltage;
        result.esc_current[i] = esc.report.current;
        result.esc_temperature[i] = esc.report.temperature - kZeroCelsius;
    }
    return result;
}

// The node's timer sees samples that its trigger has thinned out. What is due is what
// `min_interval` of the same length lets through: the first sample of each interval, counted from
// time 0.
bool CanEsc::is_due(const CanEscPorts& ports) {
    if (!ports.motors) return ports.now >= next_stop_us_;
    const uint64_t sample_us = ports.motors->timestamp;
    if (!ports.motors.is_new() || sample_us < next_command_us_) return false;
    next_command_us_ = (sample_us / interval_us_ + 1) * interval_us_;
    return true;
}

void CanEsc::step(CanEscPorts& ports) {
    if (ports.params.is_new()) configure(*ports.params);
    while (ports.can.next()) receive(*ports.can);
    if (is_due(ports)) {
        next_stop_us_ = ports.now + kStopPeriod_us;
        command(ports);
    }
    if (ports.now < next_report_us_) return;
    next_report_us_ = ports.now + kReportPeriod_us;
    announce_arming(ports);
    ports.report.publish([&] { return report(ports.now); });
}

}  // namespace stator::apps::can_esc
