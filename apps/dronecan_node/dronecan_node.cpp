// This vehicle as a node of a DroneCAN bus.
#include "dronecan_node.hpp"

#include <algorithm>
#include <string_view>

#include "get_set.hpp"
#include "stator/dronecan/port.hpp"

namespace stator::apps::dronecan_node {

namespace {

using dronecan::protocol::GetNodeInfo;
using dronecan::protocol::NodeStatus;
using dronecan::protocol::RestartNode;
using dronecan::protocol::param::GetSet;

constexpr std::string_view kName = "org.stator.vehicle";
constexpr uint64_t kStatusPeriod_us = 1'000'000;
// Since the start. The memory takes less than a second.
constexpr uint64_t kLongestLoad_us = 10'000'000;
// Each node that is on the bus is heard within it.
constexpr uint64_t kListen_us = uint64_t{1000} * NodeStatus::kMaxBroadcastingPeriodMs;
constexpr uint64_t kParameterPatience_us = 500'000;  // a requester waits for about a second
constexpr unsigned kFramesPerRelease = 4;
constexpr uint8_t kStatusPriority = 16;
constexpr uint8_t kMostUrgentAnswer = 16;  // a requester must not hold up the motors' commands
constexpr uint8_t kAllocationPriority = 30;
// Of one node. A GetSet request takes up to 33 frames.
constexpr std::array kWanted{
    dronecan::want<NodeStatus>(20), dronecan::want_anonymous<Allocator::Message>(50),
    dronecan::want<GetNodeInfo::Request>(20), dronecan::want<GetSet::Request>(2000),
    dronecan::want<RestartNode::Request>(5)};

bool is_disarmed(const DronecanNodePorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
}

}  // namespace

DronecanNode::DronecanNode() : receiver_(kWanted) {}

void DronecanNode::configure(const DronecanNodeParams& params) {
    dronecan::NodeSet nodes;
    nodes.add_range(params.first_node, params.last_node);
    nodes.add(0);  // parts that have no id yet
    receiver_.allow(nodes);
    node_id_ = static_cast<uint8_t>(params.node_id);
    receiver_.set_own_id(node_id_);
    tool_ = static_cast<uint8_t>(params.tool);
    allocator_.set_range(params.first_given, params.last_given);
    allocator_.set_own_id(node_id_);
    for (unsigned i = 0; i < serial_number_.size(); ++i) {
        serial_number_[i] = static_cast<uint8_t>(params.serial_number >> (8 * i));
    }
}

NodeStatus DronecanNode::status(uint64_t now_us) const {
    const bool warns = memory_is_bad_ || allocator_.is_full() || has_conflict_;
    return {.uptime_sec = static_cast<uint32_t>(now_us / 1'000'000),
            .health = warns ? NodeStatus::kHealthWarning : NodeStatus::kHealthOk};
}

template <class Message>
bool DronecanNode::read(Message& message) {
    if (dronecan::decode(receiver_.payload(), message)) return true;
    receiver_.count_undecodable();
    return false;
}

// As the protocol wants it: with the request's transfer id and, if that is not too urgent,
// priority.
template <class Response>
void DronecanNode::respond(const Response& response) {
    respond(receiver_.header(), receiver_.transfer_id(), response);
}
template <class Response>
void DronecanNode::respond(const dronecan::Header& request, uint8_t transfer_id,
                           const Response& response) {
    if (response_sender_.is_busy()) return;
    response_sender_.begin({.priority = std::max(request.priority, kMostUrgentAnswer),
                            .source = node_id_,
                            .destination = request.source},
                           transfer_id, response);
}

// The status was taken before the records are read here, so that once it says that all are loaded,
// none is still to come.
void DronecanNode::read_memory(DronecanNodePorts& ports) {
    while (ports.stored.next()) {
        const StoredRecord& record = *ports.stored;
        if (record.kind != StoredRecord::Kind::kCanNode) continue;
        const std::size_t length = std::min<std::size_t>(record.length, record.data.size());
        allocator_.remember(record.key, std::span(record.data).first(length));
    }
    if (ports.stored.lost() != 0) misses_records_ = true;
    const bool has_memory = ports.store.is_connected();
    const bool is_known = ports.memory && ports.memory->state != NonvolatileStatus::State::kLoading;
    const bool is_late = !is_known && ports.now >= kLongestLoad_us;
    may_give_ids_ = !has_memory || is_known || is_late;
    const bool fails = is_known && (ports.memory->state == NonvolatileStatus::State::kFailed ||
                                    ports.memory->refused != 0 || ports.memory->lost != 0);
    memory_is_bad_ = has_memory && (misses_records_ || is_late || fails);
}

void DronecanNode::handle_status(DronecanNodePorts& ports) {
    const uint8_t source = receiver_.header().source;
    allocator_.note_taken(source);
    NodeStatus status;
    if (!read(status)) return;
    const bool is_one = nodes_.hear(source, status, ports.can->timestamp);
    if (!is_one || source == node_id_) report_shared(ports, source);
}

void DronecanNode::report_shared(DronecanNodePorts& ports, uint8_t node) {
    if (shared_.has(node)) return;
    shared_.add(node);
    has_conflict_ = true;
    using Kind = CanNodeConflict::Kind;
    ports.conflict.publish([&] {
        return CanNodeConflict{.node_id = node,
                               .kind = node == node_id_ ? Kind::kOwn : Kind::kShared};
    });
}

void DronecanNode::handle_allocation(DronecanNodePorts& ports) {
    Allocator::Message request;
    // With a sender, it is another allocator's.
    if (!read(request) || receiver_.header().source != 0) return;
    const uint64_t now_us = ports.can->timestamp;
    const bool has_listened = now_us >= first_frame_us_ + kListen_us;
    if (!is_disarmed(ports) || !may_give_ids_ || !has_listened) return;
    if (allocation_sender_.is_busy()) return;
    const auto answer = allocator_.answer(request, nodes_, now_us);
    if (!answer) return;
    allocation_sender_.begin({.priority = kAllocationPriority, .source = node_id_}, allocation_id_,
                             *answer);
    allocation_id_ = static_cast<uint8_t>((allocation_id_ + 1) % dronecan::kTransferIds);
    if (answer->node_id == 0) return;
    ports.allocation.publish([&] {
        return CanAllocation{.node_id = answer->node_id, .unique_id = allocator_.unique_id()};
    });
    keep(ports, answer->node_id, allocator_.unique_id());
    const uint8_t replaced = allocator_.replaced();
    if (replaced == 0) return;
    has_conflict_ = true;
    keep(ports, replaced, {});
    ports.conflict.publish([&] {
        return CanNodeConflict{.node_id = replaced,
                               .kind = CanNodeConflict::Kind::kPart,
                               .new_node_id = answer->node_id,
                               .unique_id = allocator_.unique_id()};
    });
}

void DronecanNode::keep(DronecanNodePorts& ports, uint8_t node, const Allocator::UniqueId& owner) {
    ports.store.publish([&] {
        return StoredRecord{.key = node,
                            .kind = StoredRecord::Kind::kCanNode,
                            .length = Allocator::kUniqueIdBytes,
                            .data = owner};
    });
}

void DronecanNode::handle_info_request(uint64_t now_us) {
    GetNodeInfo::Request request;
    if (!read(request)) return;
    GetNodeInfo::Response info;
    info.status = status(now_us);
    info.software_version.major = 1;
    for (unsigned i = 0; i < serial_number_.size(); ++i) {
        info.hardware_version.unique_id[i] = serial_number_[i];
    }
    info.name.assign(kName);
    respond(info);
}

void DronecanNode::handle_restart_request(DronecanNodePorts& ports) {
    RestartNode::Request request;
    if (!read(request)) return;
    const uint8_t source = receiver_.header().source;
    const bool granted = request.magic_number == RestartNode::Request::kMagicNumber &&
                         source == tool_ && is_disarmed(ports) && ports.restart.is_connected();
    respond(RestartNode::Response{.ok = granted});
    if (granted) ports.restart.publish([&] { return RestartRequest{.source = source}; });
}

void DronecanNode::handle_parameter_request(DronecanNodePorts& ports) {
    GetSet::Request request;
    if (!read(request) || ports.now < asked_until_us_) return;
    if (!ports.request.is_connected()) return respond(GetSet::Response{});
    asked_until_us_ = ports.now + kParameterPatience_us;
    asked_ = receiver_.header();
    asked_id_ = receiver_.transfer_id();
    ++tag_;
    const bool may_write = asked_.source == tool_ && is_disarmed(ports);
    ports.request.publish([&] { return to_request(request, tag_, may_write); });
}

void DronecanNode::answer_parameter_request(const ParameterValue& value) {
    const bool is_ours = value.requester == ParameterValue::Requester::kCan && value.tag == tag_;
    if (!is_ours || asked_until_us_ == 0) return;
    asked_until_us_ = 0;
    respond(asked_, asked_id_, to_response(value));
}

void DronecanNode::handle(DronecanNodePorts& ports) {
    if (receiver_.is<NodeStatus>()) {
        handle_status(ports);
    } else if (receiver_.is<Allocator::Message>()) {
        handle_allocation(ports);
    } else if (receiver_.is<GetNodeInfo::Request>()) {
        handle_info_request(ports.now);
    } else if (receiver_.is<RestartNode::Request>()) {
        handle_restart_request(ports);
    } else if (receiver_.is<GetSet::Request>()) {
        handle_parameter_request(ports);
    }
}

void DronecanNode::receive(DronecanNodePorts& ports) {
    dronecan::Frame frame;
    if (!dronecan::from_topic(*ports.can, frame)) return;
    if (first_frame_us_ == 0) first_frame_us_ = ports.can->timestamp;
    if (receiver_.accept(frame, ports.can->timestamp)) handle(ports);
}

void DronecanNode::send_waiting(DronecanNodePorts& ports) {
    dronecan::Frame frame;
    for (unsigned i = 0; i < kFramesPerRelease; ++i) {
        const bool some = status_sender_.next(frame) || allocation_sender_.next(frame) ||
                          response_sender_.next(frame);
        if (!some) return;
        ports.frames.publish([&] { return dronecan::to_topic<CanFrame>(frame, ports.now); });
    }
}

void DronecanNode::step(DronecanNodePorts& ports) {
    if (ports.params.is_new()) configure(*ports.params);
    read_memory(ports);
    while (ports.parameter.next()) answer_parameter_request(*ports.parameter);
    while (ports.can.next()) receive(ports);
    if (ports.now >= next_status_us_) {
        next_status_us_ = ports.now + kStatusPeriod_us;
        status_sender_.begin({.priority = kStatusPriority, .source = node_id_}, status_id_,
                             status(ports.now));
        status_id_ = static_cast<uint8_t>((status_id_ + 1) % dronecan::kTransferIds);
    }
    send_waiting(ports);
}

}  // namespace stator::apps::dronecan_node
