// Serves the parameters of dronecan_node by DroneCAN's param.GetSet: tools list them by index, read
// and write them by name.
#pragma once

#include <span>
#include <string_view>

#include "dronecan/protocol/param/get_set.hpp"
#include "dronecan_node_ports.hpp"

namespace stator {

// What is written holds until the vehicle starts anew, or its graph's own parameters change. A
// value of another type, or out of range, changes nothing: the answer always has what counts now.
class ParameterServer {
  public:
    using GetSet = dronecan::protocol::param::GetSet;

    // `params`: those that the requests are about, which stay the caller's. `may_write`: whether
    // the sender may change them. Empty for one that there is not.
    static GetSet::Response answer(const GetSet::Request& request, DronecanNodeParams& params,
                                   bool may_write);
};

}  // namespace stator
