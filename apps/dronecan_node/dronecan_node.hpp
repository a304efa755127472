// This vehicle as a node of a DroneCAN bus: NodeStatus, GetNodeInfo, allocation of ids, parameters
// (GetSet), RestartNode.
#pragma once

#include "allocator.hpp"
#include "dronecan/protocol/get_node_info.hpp"
#include "dronecan/protocol/node_status.hpp"
#include "dronecan/protocol/param/get_set.hpp"
#include "dronecan/protocol/restart_node.hpp"
#include "dronecan_node_ports.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

namespace stator::apps::dronecan_node {

// Sends at most 4 frames in each activation, by a timer, so that a long answer leaves room on
// the bus. One answer at a time, and one question about a parameter: a request that comes meanwhile
// has no answer, and its sender repeats it. Without a status the vehicle counts as armed: then
// nothing can be changed, and no id is given away. Ids that were given away come back from the
// memory for records, if the graph has one; until all are loaded, none is given away. If they never
// are, the table is in this node alone, and NodeStatus warns. The table is checked against what is
// heard on the bus, and so is our own id: that two nodes use one is published, and NodeStatus warns
// from then on.
class DronecanNode {
  public:
    DronecanNode();
    void step(DronecanNodePorts& ports);
    const dronecan::ReceiverCounters& counters() const { return receiver_.counters(); }

  private:
    using GetNodeInfo = dronecan::protocol::GetNodeInfo;
    using GetSet = dronecan::protocol::param::GetSet;
    using NodeStatus = dronecan::protocol::NodeStatus;
    using RestartNode = dronecan::protocol::RestartNode;
    static constexpr unsigned kSessions = 48;
    static constexpr unsigned kMaxRequestBytes = GetSet::Request::kType.most_bytes;

    void configure(const DronecanNodeParams& params);
    void receive(DronecanNodePorts& ports);
    void handle(DronecanNodePorts& ports);
    void read_memory(DronecanNodePorts& ports);
    void handle_status(DronecanNodePorts& ports);
    void handle_allocation(DronecanNodePorts& ports);
    void keep(DronecanNodePorts& ports, uint8_t node, const Allocator::UniqueId& owner);
    void report_shared(DronecanNodePorts& ports, uint8_t node);
    void handle_info_request(uint64_t now_us);
    void handle_restart_request(DronecanNodePorts& ports);
    void handle_parameter_request(DronecanNodePorts& ports);
    void answer_parameter_request(const ParameterValue& value);
    NodeStatus status(uint64_t now_us) const;
    void send_waiting(DronecanNodePorts& ports);
    template <class Message>
    bool read(Message& message);
    template <class Response>
    void respond(const Response& response);
    template <class Response>
    void respond(const dronecan::Header& request, uint8_t transfer_id, const Response& response);

    dronecan::Receiver<kSessions, kMaxRequestBytes> receiver_;
    BusNodes nodes_;
    Allocator allocator_;
    dronecan::NodeSet shared_;  // ids that two nodes use, which has been published
    dronecan::Sender<NodeStatus::kType.most_bytes> status_sender_;
    dronecan::Sender<Allocator::Message::kType.most_bytes> allocation_sender_;
    dronecan::Sender<GetNodeInfo::Response::kType.most_bytes> response_sender_;
    std::array<uint8_t, 4> serial_number_{};
    uint64_t next_status_us_ = 0;
    uint64_t first_frame_us_ = 0;  // 0: none yet
    bool has_conflict_ = false;
    bool may_give_ids_ = false;
    bool misses_records_ = false;
    bool memory_is_bad_ = false;
    // A request about a parameter that has no answer yet: until when one is waited for, and whose
    // it is.
    uint64_t asked_until_us_ = 0;
    dronecan::Header asked_;
    uint8_t asked_id_ = 0;
    uint8_t tag_ = 0;
    uint8_t node_id_ = 0;
    uint8_t tool_ = 0;
    uint8_t status_id_ = 0;
    uint8_t allocation_id_ = 0;
};

}  // namespace stator::apps::dronecan_node
