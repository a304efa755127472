// Every type that has a generated codec and travels by itself.
#pragma once

#include "dronecan/equipment/ahrs/magnetic_field_strength2.hpp"
#include "dronecan/equipment/air_data/raw_air_data.hpp"
#include "dronecan/equipment/air_data/static_pressure.hpp"
#include "dronecan/equipment/esc/raw_command.hpp"
#include "dronecan/equipment/esc/status.hpp"
#include "dronecan/equipment/gnss/auxiliary.hpp"
#include "dronecan/equipment/gnss/fix2.hpp"
#include "dronecan/equipment/power/battery_info.hpp"
#include "dronecan/equipment/safety/arming_status.hpp"
#include "dronecan/protocol/dynamic_node_id/allocation.hpp"
#include "dronecan/protocol/get_node_info.hpp"
#include "dronecan/protocol/node_status.hpp"
#include "dronecan/protocol/param/get_set.hpp"
#include "dronecan/protocol/restart_node.hpp"

namespace stator::dronecan {

// Calls `visit` with a pointer to each type, which tells the type and is null.
template <class Visit>
void for_every_type(Visit visit) {
    visit(static_cast<protocol::NodeStatus*>(nullptr));
    visit(static_cast<protocol::GetNodeInfo::Request*>(nullptr));
    visit(static_cast<protocol::GetNodeInfo::Response*>(nullptr));
    visit(static_cast<protocol::RestartNode::Request*>(nullptr));
    visit(static_cast<protocol::RestartNode::Response*>(nullptr));
    visit(static_cast<protocol::dynamic_node_id::Allocation*>(nullptr));
    visit(static_cast<protocol::param::GetSet::Request*>(nullptr));
    visit(static_cast<protocol::param::GetSet::Response*>(nullptr));
    visit(static_cast<equipment::esc::RawCommand*>(nullptr));
    visit(static_cast<equipment::esc::Status*>(nullptr));
    visit(static_cast<equipment::gnss::Fix2*>(nullptr));
    visit(static_cast<equipment::gnss::Auxiliary*>(nullptr));
    visit(static_cast<equipment::ahrs::MagneticFieldStrength2*>(nullptr));
    visit(static_cast<equipment::air_data::StaticPressure*>(nullptr));
    visit(static_cast<equipment::air_data::RawAirData*>(nullptr));
    visit(static_cast<equipment::power::BatteryInfo*>(nullptr));
    visit(static_cast<equipment::safety::ArmingStatus*>(nullptr));
}

}  // namespace stator::dronecan
