// Decides where to go: between the commander's flight mode and the trajectory.
#pragma once

#include <cstdint>

#include "navigator_ports.hpp"
#include "route.hpp"

namespace stator::apps::navigator {

// Runs at a fixed period. A mode that begins makes its first goal; each goal that is reached makes
// the next one, until the result says finished. A mission that was left goes on where it was left.
// Without position or home it keeps its goal; in modes that others fly it stops where it is.
class Navigator {
  public:
    void step(NavigatorPorts& ports);

  private:
    using Nav = VehicleStatus::NavState;

    void take_inputs(const NavigatorPorts& ports);
    void begin_mode(const NavigatorPorts& ports);
    void advance(const NavigatorPorts& ports);
    void advance_takeoff(const NavigatorPorts& ports);
    void advance_mission(const NavigatorPorts& ports);
    void advance_return(const NavigatorPorts& ports);
    void advance_landing(const NavigatorPorts& ports);
    void begin_item(const NavigatorPorts& ports);
    bool item_is_reached(const Item& item) const;
    void finish(Nav next);

    void go(const math::Vector3<float>& position_N, float heading, float speed);
    void start(GotoSetpoint::Kind kind);
    float heading_to(const math::Vector3<float>& position_N) const;
    Item item(const NavigatorPorts& ports) const;

    GotoSetpoint goal_{};
    bool has_arrived_ = false;
    math::Vector3<float> position_N_ = math::Vector3<float>::Zero();
    HomePosition home_{};

    bool is_armed_ = false;
    Nav nav_state_ = Nav::kHold;
    unsigned phase_ = 0;  // within the mode, or within the mission's item
    float in_phase_s_ = 0.0F;
    bool is_finished_ = false;
    Nav next_ = Nav::kHold;

    Eigen::Vector2f origin_N_ = Eigen::Vector2f::Zero();
    bool mission_is_valid_ = false;
    unsigned current_ = 0;
    int reached_ = -1;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::navigator
