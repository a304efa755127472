// Commands, and their answers.
#include <algorithm>

#include "flight_modes.hpp"
#include "mavlink.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::mavlink {

namespace {

namespace cmd = mav::mav_cmd;
namespace result = mav::mav_result;
using Action = VehicleCommand::Action;
using Nav = VehicleStatus::NavState;

constexpr float kForce = 21196.0F;  // of COMPONENT_ARM_DISARM: disarm in the air, too
// Of an orbit.
constexpr float kUsualRadius = 10.0F;
constexpr float kShortestRadius = 1.0F;
constexpr float kLongestRadius = 1000.0F;
constexpr float kFastest = 50.0F;
constexpr double kMotorFunctions = 16.0;  // of ACTUATOR_TEST
constexpr uint64_t kPatience_us = 200'000;
constexpr float kNan = math::canonical_nan<float>();

// What a command needs; none: everybody may, or it is not known.
std::optional<Right> right_for(uint16_t command, const std::array<float, 4>& p) {
    switch (command) {
        case cmd::kPreflightRebootShutdown:
        case cmd::kPreflightCalibration:
        case cmd::kDoMotorTest:
        case cmd::kActuatorTest:
            return Right::kService;
        case cmd::kDoFlighttermination:
            return Right::kKill;
        case cmd::kComponentArmDisarm:
            return p[1] == kForce ? Right::kKill : Right::kFly;
        case cmd::kDoSetMode:
        case cmd::kNavTakeoff:
        case cmd::kNavLand:
        case cmd::kNavReturnToLaunch:
        case cmd::kMissionStart:
        case cmd::kDoSetMissionCurrent:
        case cmd::kDoReposition:
        case cmd::kDoOrbit:
            return Right::kFly;
        default:
            return {};
    }
}

VehicleCommand mode_wish(Nav mode) {
    return {.action = Action::kSetMode,
            .nav_state = static_cast<uint8_t>(mode),
            .position = {kNan, kNan, kNan},
            .heading = kNan};
}

}  // namespace

void Mavlink::acknowledge(unsigned number, mav::Address to, uint16_t command, uint32_t outcome) {
    mav::CommandAck ack{.command = command, .result = static_cast<uint8_t>(outcome)};
    ack.target_system = to.system;
    ack.target_component = to.component;
    link(number).send(ack);
}

void Mavlink::answer(const Request& request, uint32_t outcome) {
    if (!request.is_silent) acknowledge(request.link, request.from, request.command, outcome);
}

// The answer goes out before the message, as some wait for it first.
void Mavlink::handle_request_message(const Request& request, uint32_t id, MavlinkPorts& ports) {
    Link& to = link(request.link);
    to.rehearse(true);
    const Told told = telemetry_.tell(id, to, ports);
    to.rehearse(false);
    uint32_t outcome = result::kAccepted;
    if (told == Told::kUnknown) outcome = result::kUnsupported;
    if (told == Told::kNothing) outcome = result::kTemporarilyRejected;
    answer(request, outcome);
    if (outcome == result::kAccepted) telemetry_.tell(id, to, ports);
}

// One by its number, or all. A station waits for each that the answer promises, so they come as the
// line has room.
void Mavlink::handle_request_modes(const Request& request) {
    const auto number = math::saturate<uint32_t>(request.param[1]);
    if (number > kModesToChoose) return answer(request, result::kDenied);
    Line& line = lines_[request.link];
    line.mode_next = static_cast<uint8_t>(number == 0 ? 0 : number - 1);
    line.mode_end = static_cast<uint8_t>(number == 0 ? kModesToChoose : number);
    answer(request, result::kAccepted);
}

void Mavlink::handle_command(const Request& request, MavlinkPorts& ports) {
    const auto& p = request.param;
    Line& line = lines_[request.link];
    const auto id = math::saturate<uint32_t>(p[0]);
    const auto right = right_for(request.command, p);
    if (right && !line.link.allows(*right)) return answer(request, result::kDenied);
    switch (request.command) {
        case cmd::kRequestMessage:
            if (id == mav::AvailableModes::kId) return handle_request_modes(request);
            return handle_request_message(request, id, ports);
        case cmd::kGetHomePosition:
            return handle_request_message(request, mav::HomePosition::kId, ports);
        case cmd::kRequestAutopilotCapabilities:
            return handle_request_message(request, mav::AutopilotVersion::kId, ports);
        case cmd::kSetMessageInterval: {
            const bool is_set = math::is_finite(p[1]) && line.streams.set(id, p[1], ports.now);
            return answer(request, is_set ? result::kAccepted : result::kDenied);
        }
        case cmd::kGetMessageInterval: {
            const int32_t interval = line.streams.interval_us(id);
            answer(request, interval == 0 ? result::kDenied : result::kAccepted);
            line.link.send(mav::MessageInterval{.interval_us = interval,
                                                .message_id = static_cast<uint16_t>(id)});
            return;
        }
        case cmd::kPreflightRebootShutdown:
            return restart(request, ports);
        case cmd::kPreflightCalibration:
            return calibrate(request, ports);
        default:
            return handle_flight_command(request, ports);
    }
}

// Of the vehicle alone, and as it is: a board cannot switch itself off.
void Mavlink::restart(const Request& request, MavlinkPorts& ports) {
    const bool is_known =
        request.param[0] == 1.0F && request.param[1] == 0.0F && ports.restart.is_connected();
    if (!is_known) return answer(request, result::kUnsupported);
    const bool is_disarmed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    if (!is_disarmed) return answer(request, result::kTemporarilyRejected);
    answer(request, result::kAccepted);
    if (restarted_us_ == ports.now) return;  // asked twice
    restarted_us_ = ports.now;
    ports.restart.publish([&] { return RestartRequest{.source = request.from.system}; });
}

// One of them, disarmed; all zeros end the one that runs.
void Mavlink::calibrate(const Request& request, MavlinkPorts& ports) {
    using Kind = CalibrationRequest::Action;
    const auto& p = request.param;
    const std::array<double, 7> wanted{static_cast<double>(p[0]),     static_cast<double>(p[1]),
                                       static_cast<double>(p[2]),     static_cast<double>(p[3]),
                                       request.latitude_deg,          request.longitude_deg,
                                       static_cast<double>(request.z)};
    const auto count = std::ranges::count_if(wanted, [](double value) { return value != 0.0; });
    Kind kind = Kind::kCancel;
    if (wanted[0] == 1.0) kind = Kind::kGyro;
    if (wanted[1] == 1.0) kind = Kind::kMag;
    if (wanted[4] == 1.0) kind = Kind::kAccel;
    if (wanted[4] == 2.0) kind = Kind::kLevel;
    const bool is_known = count == 0 || (count == 1 && kind != Kind::kCancel);
    if (!is_known || !ports.calibration.is_connected())
        return answer(request, result::kUnsupported);
    const bool is_disarmed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    const bool is_busy = ports.calibrating && ports.calibrating->is_running;
    const bool is_possible = kind == Kind::kCancel || (is_disarmed && !is_busy);
    if (!is_possible) return answer(request, result::kTemporarilyRejected);
    answer(request, result::kAccepted);
    if (calibrated_us_ == ports.now) return;  // asked twice
    calibrated_us_ = ports.now;
    ports.calibration.publish([&] { return CalibrationRequest{.action = kind}; });
}

void Mavlink::handle_flight_command(const Request& request, MavlinkPorts& ports) {
    const auto& p = request.param;
    switch (request.command) {
        case cmd::kComponentArmDisarm: {
            const bool is_kill = p[0] == 0.0F && p[1] == kForce;
            if (p[0] != 0.0F && p[0] != 1.0F) return answer(request, result::kDenied);
            Action action = p[0] == 1.0F ? Action::kArm : Action::kDisarm;
            if (is_kill) action = Action::kKill;
            return command(request, {.action = action}, ports);
        }
        case cmd::kDoFlighttermination:
            if (!(p[0] > 0.5F)) return answer(request, result::kUnsupported);
            return command(request, {.action = Action::kKill}, ports);
        case cmd::kDoSetMode:
            if ((math::saturate<uint32_t>(p[0]) & mav::mav_mode_flag::kCustomModeEnabled) == 0) {
                return answer(request, result::kUnsupported);
            }
            return set_mode(request, math::saturate<uint32_t>(p[1]), math::saturate<uint32_t>(p[2]),
                            ports);
        case cmd::kNavTakeoff: {
            VehicleCommand wish = mode_wish(Nav::kTakeoff);
            wish.position[2] = height_of(request.z, request.frame);
            return command(request, wish, ports);
        }
        case cmd::kNavLand:
            return command(request, mode_wish(Nav::kLand), ports);
        case cmd::kNavReturnToLaunch:
            return command(request, mode_wish(Nav::kReturn), ports);
        case cmd::kMissionStart:
            return command(request, mode_wish(Nav::kMission), ports);
        case cmd::kDoSetMissionCurrent: {
            const bool is_number = p[0] >= 0.0F && p[0] < 65535.0F;
            if (!is_number) return answer(request, result::kDenied);
            return command(request,
                           {.action = Action::kSetItem, .item = math::saturate<uint16_t>(p[0])},
                           ports);
        }
        case cmd::kDoReposition:
            return command(request, go_to(request), ports);
        case cmd::kDoOrbit:
            return orbit(request, ports);
        case cmd::kDoMotorTest: {
            // By its number and in percent, one motor. Not a number: not given.
            const bool is_one = !(request.latitude_deg > 1.0) && p[1] == 0.0F;
            const bool is_numbered = !(request.longitude_deg == 1.0);  // not in a sequence
            if (!is_one || !is_numbered) return answer(request, result::kUnsupported);
            return test_motor(request, p[0], 0.01F * p[2], p[3], ports);
        }
        case cmd::kActuatorTest: {
            // Functions of outputs from 1 on are motors.
            const double function = request.latitude_deg;
            if (!(function >= 1.0 && function <= kMotorFunctions)) {
                return answer(request, result::kUnsupported);
            }
            return test_motor(request, static_cast<float>(function), p[0], p[1], ports);
        }
        default:
            return answer(request, result::kUnsupported);
    }
}

// `number`: from 1. `thrust`: not a number ends a test.
void Mavlink::test_motor(const Request& request, float number, float thrust, float duration,
                         MavlinkPorts& ports) {
    if (!(number >= 1.0F)) return answer(request, result::kDenied);
    command(request,
            {.action = Action::kTestMotor,
             .motor = math::saturate<uint8_t>(number - 1.0F),
             .thrust = thrust,
             .duration = duration},
            ports);
}

void Mavlink::set_mode(const Request& request, uint32_t main, uint32_t sub, MavlinkPorts& ports) {
    const FlightMode* const mode = find_mode(main, sub);
    if (mode == nullptr) return answer(request, result::kUnsupported);
    command(request, mode_wish(mode->nav_state), ports);
}

// Down in N. A height is above mean sea level, or above home in a relative frame.
float Mavlink::height_of(float z, uint8_t frame) const {
    const bool is_relative = frame == mav::mav_frame::kGlobalRelativeAlt ||
                             frame == mav::mav_frame::kGlobalRelativeAltInt;
    return is_relative ? telemetry_.home_down() - z : telemetry_.reference_altitude() - z;
}

// What is not given stays as it is.
VehicleCommand Mavlink::go_to(const Request& request) const {
    VehicleCommand wish{.action = Action::kGo,
                        .position = {kNan, kNan, height_of(request.z, request.frame)},
                        .heading = request.param[3]};
    const bool is_place = math::is_finite(request.latitude_deg) &&
                          math::is_finite(request.longitude_deg) && telemetry_.knows_earth();
    if (is_place) {
        const auto at = telemetry_.frame().to_local({request.latitude_deg, request.longitude_deg});
        wish.position[0] = static_cast<float>(at.north);
        wish.position[1] = static_cast<float>(at.east);
    }
    return wish;
}

// Until something else is wished for: a number of turns is not counted.
void Mavlink::orbit(const Request& request, MavlinkPorts& ports) {
    const auto& p = request.param;
    // Looks at the middle if nothing is given; or keeps its heading.
    const bool faces_centre = math::is_nan(p[2]) || p[2] == 0.0F;
    const bool keeps_heading = p[2] == 1.0F || p[2] == 5.0F;
    const bool is_endless = math::is_nan(p[3]) || p[3] == 0.0F;
    if (!is_endless || (!faces_centre && !keeps_heading)) {
        return answer(request, result::kUnsupported);
    }
    const float radius = math::is_nan(p[0]) ? kUsualRadius : p[0];
    const bool is_round =
        math::abs(radius) >= kShortestRadius && math::abs(radius) <= kLongestRadius;
    const bool is_speed = math::is_nan(p[1]) || (p[1] > 0.0F && p[1] <= kFastest);
    if (!is_round || !is_speed) return answer(request, result::kDenied);
    VehicleCommand wish = go_to(request);
    wish.action = Action::kOrbit;
    wish.radius = radius;
    wish.speed = p[1];
    wish.faces_centre = faces_centre;
    command(request, wish, ports);
}

// Hands a wish to the node that decides. One that is repeated before its answer gets one answer.
void Mavlink::command(const Request& request, const VehicleCommand& wish, MavlinkPorts& ports) {
    if (!ports.command.is_connected()) return answer(request, result::kUnsupported);
    if (pending_.is_one) {
        const bool is_repeated = pending_.from == request.from &&
                                 pending_.command == request.command &&
                                 pending_.link == request.link;
        if (!is_repeated) answer(request, result::kTemporarilyRejected);
        return;
    }
    const auto tag = static_cast<uint8_t>(pending_.tag + 1);
    pending_ = {.is_one = true,
                .is_silent = request.is_silent,
                .link = request.link,
                .from = request.from,
                .command = request.command,
                .tag = tag,
                .since_us = ports.now};
    ports.command.publish([&] {
        VehicleCommand sent = wish;
        sent.tag = tag;
        return sent;
    });
}

void Mavlink::take_answers(MavlinkPorts& ports) {
    const auto end = [this](uint32_t outcome) {
        pending_.is_one = false;
        if (pending_.is_silent) return;
        acknowledge(pending_.link, pending_.from, pending_.command, outcome);
    };
    while (ports.ack.next()) {
        if (pending_.is_one && ports.ack->tag == pending_.tag) {
            end(static_cast<uint32_t>(ports.ack->result));
        }
    }
    if (pending_.is_one && ports.now - pending_.since_us > kPatience_us) end(result::kFailed);
}

}  // namespace stator::apps::mavlink
