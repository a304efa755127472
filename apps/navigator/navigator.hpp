// Decides where to go: between the commander's flight mode and the trajectory.
#pragma once

#include <array>
#include <cstdint>

#include "mission_check.hpp"
#include "navigator_ports.hpp"

namespace stator::apps::navigator {

// Runs at a fixed period. A mode that begins makes its first goal; each goal that is reached makes
// the next one, until the result says finished. A mission that was left goes on where it was left.
// Without position or home it keeps its goal; in modes that others fly it stops where it is.
//
// The mission device has the items; a window of them is here (item_reader.hpp). A mission is valid
// once all its items have been looked at from this home.
class Navigator {
  public:
    static constexpr unsigned kMaxRallyPoints = 16;
    // Lower it has not taken off yet.
    static constexpr float kHasLeftGround = 1.0F;  // m

    void step(NavigatorPorts& ports);

  private:
    using Nav = VehicleStatus::NavState;
    using Fault = MissionResult::Fault;

    // navigator.cpp
    void take_inputs(const NavigatorPorts& ports);
    void begin_mode();
    void take_command(const NavigatorPorts& ports);
    math::Vector3<float> place_of(const VehicleCommand& command) const;
    void begin_orbit(const VehicleCommand& command);
    void advance_orbit();
    void go_on_with(unsigned item);
    void advance(const NavigatorPorts& ports, float dt);
    void advance_takeoff(const NavigatorPorts& ports);
    void advance_return(const NavigatorPorts& ports);
    void choose_return_place();
    void advance_landing(const NavigatorPorts& ports);
    bool has_stopped_sinking(float dt);
    void finish(Nav next);
    void go(const math::Vector3<float>& position_N, float heading, const Sequence::Speeds& speeds);
    void start(GotoSetpoint::Kind kind);
    float heading_to(const math::Vector3<float>& position_N) const;
    void publish(NavigatorPorts& ports);

    // navigator_mission.cpp
    void advance_mission(const NavigatorPorts& ports, float dt);
    void take_next(const Mission& mission, Situation situation);
    void begin_item();
    void climb_first();
    void begin_figure(const Item& item);
    bool is_at_place(float near_enough) const;
    bool is_over() const;
    void leave_item();
    void wait_here();
    void look();

    // navigator_plans.cpp
    void read_plans(const NavigatorPorts& ports);
    bool read_fence(const Mission& mission);
    bool read_rally_points(const Mission& mission);
    void check_mission(const NavigatorPorts& ports);
    void check_rally_points(const NavigatorPorts& ports);
    bool can_place(const RawItem& item) const;
    Fault fault(const NavigatorPorts& ports) const;
    void watch_fence(NavigatorPorts& ports);
    FenceLimits usual_fence(const NavigatorPorts& ports) const;

    GotoSetpoint goal_{};
    bool has_arrived_ = false;
    math::Vector3<float> position_N_ = math::Vector3<float>::Zero();
    float heading_ = 0.0F;
    math::Vector3<float> home_N_ = math::Vector3<float>::Zero();  // on the ground: here
    PlaceFrame frame_;

    bool is_armed_ = false;
    Nav nav_state_ = Nav::kHold;
    unsigned phase_ = 0;  // within the mode, or within the mission's item
    float in_phase_s_ = 0.0F;
    bool is_finished_ = false;
    Nav next_ = Nav::kHold;
    // Of the return and the landing that end a mission: the mission's. Else none.
    Sequence::Speeds speeds_;

    // The mission that is flown.
    Sequence sequence_;
    bool is_over_ = false;  // the whole mission
    bool waits_ = false;    // MissionResult
    bool has_left_ground_ = false;
    unsigned first_item_ = 0;  // with which the next flight's mission begins
    // Down, of the take-off that was wished for; not a number: the parameter's height.
    float takeoff_z_ = math::canonical_nan<float>();
    // Flown in hold, until it is left or another place is wished for.
    struct Orbit {
        bool is_on = false;
        bool faces_centre = false;
        math::Vector3<float> centre_N = math::Vector3<float>::Zero();
        float radius = 0.0F;  // below 0: anticlockwise
    };
    Orbit orbit_;
    int reached_ = -1;
    uint32_t flown_id_ = 0;
    float starved_s_ = 0.0F;  // without an item that is needed

    // A return, and the landing behind it.
    math::Vector3<float> return_N_ = math::Vector3<float>::Zero();
    math::Vector3<float> land_N_ = math::Vector3<float>::Constant(math::canonical_nan<float>());
    float lowest_ = 0.0F;
    float since_lowest_s_ = 0.0F;

    // The plans of the mission device.
    ItemReader reader_;
    Geofence fence_;
    uint64_t frame_us_ = 0;     // of the frame that all of this stands in
    bool lacks_place_ = false;  // an item waits for a place or height that is not known yet
    uint32_t fence_id_ = 0;
    unsigned fence_read_ = 0;
    Fault fence_fault_ = Fault::kNone;  // of the fence and the rally points
    std::array<math::Vector3<float>, kMaxRallyPoints> rally_N_{};
    uint32_t rally_id_ = 0;
    unsigned rally_read_ = 0;
    MissionCheck check_;
    uint32_t checking_id_ = 0;
    bool is_checking_ = false;
    uint32_t checked_id_ = 0;  // of the verdict; 0: none yet
    Fault verdict_ = Fault::kUnread;
    unsigned fault_item_ = 0;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::navigator
