// Serves the parameters of a node.
#include "parameter_server.hpp"

#include <algorithm>

namespace stator {

namespace {

using GetSet = ParameterServer::GetSet;
using Value = dronecan::protocol::param::Value;
using NumericValue = dronecan::protocol::param::NumericValue;

struct Row {
    std::string_view name;
    int32_t DronecanNodeParams::*member;
    int32_t least;
    int32_t most;
    int32_t standard;
};

// Ranges and defaults as in dronecan_node.yaml. Not the node's id: others know us by it.
constexpr std::array kRows{
    Row{"dronecan_node.serial_number", &DronecanNodeParams::serial_number, 0, INT32_MAX, 1},
    Row{"dronecan_node.first_node", &DronecanNodeParams::first_node, 1, 127, 1},
    Row{"dronecan_node.last_node", &DronecanNodeParams::last_node, 1, 127, 127},
    Row{"dronecan_node.tool", &DronecanNodeParams::tool, 0, 127, 127},
    Row{"dronecan_node.first_given", &DronecanNodeParams::first_given, 1, 125, 50},
    Row{"dronecan_node.last_given", &DronecanNodeParams::last_given, 1, 125, 125},
};

// By name if there is one, else by index.
const Row* find(const GetSet::Request& request) {
    const auto name = request.name.view();
    if (name.empty()) return request.index < kRows.size() ? &kRows[request.index] : nullptr;
    for (const Row& row : kRows) {
        if (std::equal(row.name.begin(), row.name.end(), name.begin(), name.end())) return &row;
    }
    return nullptr;
}

Value integer(int32_t value) {
    return {.tag = Value::Tag::kIntegerValue, .integer_value = value};
}
NumericValue bound(int32_t value) {
    return {.tag = NumericValue::Tag::kIntegerValue, .integer_value = value};
}

}  // namespace

GetSet::Response ParameterServer::answer(const GetSet::Request& request, DronecanNodeParams& params,
                                         bool may_write) {
    GetSet::Response response;
    const Row* const row = find(request);
    if (row == nullptr) return response;
    const Value& wanted = request.value;
    if (may_write && wanted.tag == Value::Tag::kIntegerValue &&
        wanted.integer_value >= row->least && wanted.integer_value <= row->most) {
        params.*row->member = static_cast<int32_t>(wanted.integer_value);
    }
    response.value = integer(params.*row->member);
    response.default_value = integer(row->standard);
    response.min_value = bound(row->least);
    response.max_value = bound(row->most);
    response.name.assign(row->name);
    return response;
}

}  // namespace stator
