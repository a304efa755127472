// This vehicle as a MAVLink system.
#include "mavlink.hpp"

#include <algorithm>
#include <string_view>

#include "stator/elapsed.hpp"

namespace stator::apps::mavlink {

namespace {

constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;

double degrees_of(int32_t e7) {
    return e7 == INT32_MAX ? math::canonical_nan<double>() : static_cast<double>(e7) * 1e-7;
}

}  // namespace

void Mavlink::configure(const MavlinkParams& params) {
    own_ = {static_cast<uint8_t>(params.system_id), kComponent};
    const auto settings = [](int32_t role, int32_t rights, int32_t rate) {
        return LinkSettings{.role = static_cast<Role>(role),
                            .rights = static_cast<uint32_t>(rights),
                            .most_bytes_per_s = static_cast<uint32_t>(rate)};
    };
    link(0).set(settings(params.role1, params.allows1, params.rate1));
    link(1).set(settings(params.role2, params.allows2, params.rate2));
    for (Line& line : lines_) {
        line.link.set_own(own_);
        line.streams.use(line.link.role());
    }
}

// Zeros are for all.
template <class Message>
bool Mavlink::is_for_us(const Message& message) const {
    return (message.target_system == 0 || message.target_system == own_.system) &&
           (message.target_component == 0 || message.target_component == own_.component);
}

// Never back to where it came from.
void Mavlink::forward(unsigned from, const mav::Frame& frame) {
    for (unsigned to = 0; to < kLinks; ++to) {
        if (to == from || !link(to).is_open() || !link(from).allows(Right::kForward)) continue;
        if (router_.goes_on(frame, own_, to)) link(to).forward(frame.bytes);
    }
}

bool Mavlink::counts(unsigned number, const mav::Frame& frame, uint64_t now_us) {
    const Link& from = link(number);
    return !from.signs() || signing_.takes(frame, from.allows(Right::kOpen), now_us);
}

// Twice in a row is once: clients repeat it, as it has no answer. What came of it, people read.
void Mavlink::set_up_signing(unsigned number, const mav::Frame& frame, const MavlinkPorts& ports) {
    const auto setup = mav::decode<mav::SetupSigning>(frame.payload);
    const bool is_ours = setup.target_system == own_.system &&
                         (setup.target_component == own_.component || setup.target_component == 0);
    if (!is_ours) return;
    const auto tell = [&](std::string_view words) {
        mav::Statustext text{.severity = mav::mav_severity::kWarning};
        std::ranges::copy(words, text.text.begin());
        link(number).send(text);
    };
    const bool is_disarmed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    if (!link(number).allows(Right::kSign)) return tell("signing: not allowed on this line");
    if (!is_disarmed) return tell("signing: refused while armed");
    mav::Fingerprint fingerprint{};
    std::copy_n(setup.secret_key.begin(), fingerprint.size(), fingerprint.begin());
    const bool is_blank = fingerprint == mav::Fingerprint{};
    if (is_blank && setup.initial_timestamp != 0) return tell("signing: refused a blank key");
    if (is_blank) {
        link(number).adopt({});
        signing_.restart({}, ports.now);
        return tell("signing: off");
    }
    link(number).adopt(fingerprint);
    signing_.restart(setup.initial_timestamp, ports.now);
    tell("signing: on, with a new key");
}

void Mavlink::handle(unsigned number, const mav::Frame& frame, MavlinkPorts& ports) {
    if (frame.source == own_) return;  // our own, come back by another way
    if (!counts(number, frame, ports.now)) return;
    router_.hear(number, frame.source, ports.now);
    forward(number, frame);
    if (frame.known == nullptr) return;
    switch (frame.id) {
        case mav::CommandLong::kId: {
            const auto c = mav::decode<mav::CommandLong>(frame.payload);
            if (!is_for_us(c)) return;
            return handle_command({.link = number,
                                   .from = frame.source,
                                   .command = c.command,
                                   .frame = mav::mav_frame::kGlobal,
                                   .param = {c.param1, c.param2, c.param3, c.param4},
                                   .latitude_deg = static_cast<double>(c.param5),
                                   .longitude_deg = static_cast<double>(c.param6),
                                   .z = c.param7},
                                  ports);
        }
        case mav::CommandInt::kId: {
            const auto c = mav::decode<mav::CommandInt>(frame.payload);
            if (!is_for_us(c)) return;
            return handle_command({.link = number,
                                   .from = frame.source,
                                   .command = c.command,
                                   .frame = c.frame,
                                   .param = {c.param1, c.param2, c.param3, c.param4},
                                   .latitude_deg = degrees_of(c.x),
                                   .longitude_deg = degrees_of(c.y),
                                   .z = c.z},
                                  ports);
        }
        case mav::SetMode::kId: {
            const auto c = mav::decode<mav::SetMode>(frame.payload);
            if (c.target_system != own_.system) return;
            const auto flag = static_cast<float>(c.base_mode);
            return handle_command({.link = number,
                                   .from = frame.source,
                                   .command = mav::mav_cmd::kDoSetMode,
                                   .frame = 0,
                                   .param = {flag, static_cast<float>(c.custom_mode >> 16 & 0xFFU),
                                             static_cast<float>(c.custom_mode >> 24), 0.0F},
                                   .latitude_deg = 0.0,
                                   .longitude_deg = 0.0,
                                   .z = 0.0F},
                                  ports);
        }
        case mav::Ping::kId: {
            const auto ping = mav::decode<mav::Ping>(frame.payload);
            if (ping.target_system != 0 || ping.target_component != 0) return;
            link(number).send(mav::Ping{.time_usec = ping.time_usec,
                                        .seq = ping.seq,
                                        .target_system = frame.source.system,
                                        .target_component = frame.source.component});
            return;
        }
        case mav::Timesync::kId: {
            const auto sync = mav::decode<mav::Timesync>(frame.payload);
            if (sync.tc1 != 0 || !is_for_us(sync)) return;
            link(number).send(mav::Timesync{.tc1 = static_cast<int64_t>(ports.now * 1000),
                                            .ts1 = sync.ts1,
                                            .target_system = frame.source.system,
                                            .target_component = frame.source.component});
            return;
        }
        case mav::SetupSigning::kId:
            return set_up_signing(number, frame, ports);
        case mav::RadioStatus::kId: {
            if (link(number).role() != Role::kRadio) return;
            link(number).take_radio(mav::decode<mav::RadioStatus>(frame.payload).txbuf);
            return;
        }
        case mav::MissionSetCurrent::kId: {
            const auto c = mav::decode<mav::MissionSetCurrent>(frame.payload);
            if (!is_for_us(c)) return;
            return handle_command({.link = number,
                                   .from = frame.source,
                                   .command = mav::mav_cmd::kDoSetMissionCurrent,
                                   .frame = 0,
                                   .is_silent = true,
                                   .param = {static_cast<float>(c.seq), 0.0F, 0.0F, 0.0F},
                                   .latitude_deg = 0.0,
                                   .longitude_deg = 0.0,
                                   .z = 0.0F},
                                  ports);
        }
        default:
            if (control_.handle(link(number), number, frame, telemetry_, ports)) return;
            if (plans_.handle(link(number), number, frame, ports)) return;
            if (files_.handle(link(number), number, frame, ports.now)) return;
            if (consoles_.handle(link(number), number, frame, ports)) return;
            parameters_.handle(link(number), number, frame, ports);
            return;
    }
}

void Mavlink::receive(unsigned number, Input<SerialBytes>& received, MavlinkPorts& ports) {
    std::span<const uint8_t> silence;
    while (const auto frame = link(number).next(silence, ports.now)) handle(number, *frame, ports);
    while (received.next()) {
        const SerialBytes& piece = *received;
        const std::size_t length = std::min<std::size_t>(piece.length, piece.data.size());
        std::span<const uint8_t> bytes = std::span(piece.data).first(length);
        while (const auto frame = link(number).next(bytes, ports.now)) {
            handle(number, *frame, ports);
        }
    }
}

// Each item of the mission that is reached, once, on all lines.
void Mavlink::tell_reached(const MavlinkPorts& ports) {
    if (!ports.result || ports.result->seq_reached == reached_) return;
    reached_ = ports.result->seq_reached;
    if (reached_ < 0) return;
    for (Line& line : lines_) {
        line.link.send(mav::MissionItemReached{.seq = static_cast<uint16_t>(reached_)});
    }
}

void Mavlink::tell_notices(MavlinkPorts& ports) {
    while (ports.notice.next()) {
        const StatusText& notice = *ports.notice;
        mav::Statustext text{.severity = static_cast<uint8_t>(notice.severity)};
        for (std::size_t i = 0; i < text.text.size(); ++i) {
            text.text[i] = static_cast<char>(notice.text[i]);
        }
        for (Line& line : lines_) line.link.send(text);
    }
}

void Mavlink::tell_due(unsigned number, const MavlinkPorts& ports) {
    Line& line = lines_[number];
    // A station that asks too much must not think that the vehicle is gone.
    if (line.streams.take(mav::Heartbeat::kId, ports.now)) {
        telemetry_.tell(mav::Heartbeat::kId, line.link, ports);
    }
    if (line.mode_next != line.mode_end && line.link.has_room_for_bulk()) {
        Telemetry::tell_mode(line.mode_next++, line.link);
    }
    for (unsigned i = 0; i < kStreamsAtOnce && line.link.has_room_for_streams(); ++i) {
        const uint16_t id = line.streams.take_due(ports.now);
        if (id == kNoStream) return;
        telemetry_.tell(id, line.link, ports);
    }
}

void Mavlink::send_waiting(unsigned number, Output<SerialBytes>& output) {
    SerialBytes piece{};
    while (link(number).next_piece(piece)) {
        output.publish([&] { return piece; });
        piece = {};
    }
}

void Mavlink::step(MavlinkPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    if (ports.params.is_new()) configure(*ports.params);
    if (ports.line1) link(0).take_status(*ports.line1);
    if (ports.line2) link(1).take_status(*ports.line2);
    if (std::ranges::none_of(lines_, [](const Line& line) { return line.link.is_open(); })) return;
    telemetry_.update(ports);
    signing_.step(link(0).signs() || link(1).signs(), ports);
    for (unsigned i = 0; i < kLinks; ++i) {
        link(i).set_time(static_cast<uint8_t>(i), signing_.time(ports.now));
    }
    for (Line& line : lines_) {
        line.link.refill(dt);
        if (telemetry_.is_status_new()) {
            line.streams.hasten(mav::Heartbeat::kId, ports.now);
            line.streams.hasten(mav::CurrentMode::kId, ports.now);
        }
        if (telemetry_.is_mission_new()) line.streams.hasten(mav::MissionCurrent::kId, ports.now);
    }
    receive(0, ports.received1, ports);
    receive(1, ports.received2, ports);
    take_answers(ports);
    control_.publish(ports);
    plans_.step(lines_, ports);
    parameters_.step(lines_, ports);
    files_.step(lines_, ports);
    consoles_.step(lines_, ports);
    tell_reached(ports);
    tell_notices(ports);
    for (unsigned i = 0; i < kLinks; ++i) {
        if (link(i).is_open()) tell_due(i, ports);
    }
    send_waiting(0, ports.send1);
    send_waiting(1, ports.send2);
}

}  // namespace stator::apps::mavlink
