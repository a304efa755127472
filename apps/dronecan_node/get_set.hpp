// DroneCAN's param.GetSet in the words of the node that has all parameters, and back.
#pragma once

#include "dronecan/protocol/param/get_set.hpp"
#include "dronecan_node_ports.hpp"

namespace stator::apps::dronecan_node {

// Without `may_write`, and if the value fits no type of ours, it asks for the value only: the
// protocol's answer has what counts in either case, and no word for a refusal.
ParameterRequest to_request(const dronecan::protocol::param::GetSet::Request& request, uint8_t tag,
                            bool may_write);

// Empty for a parameter that there is not.
dronecan::protocol::param::GetSet::Response to_response(const ParameterValue& value);

}  // namespace stator::apps::dronecan_node
