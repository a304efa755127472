// This vehicle as a MAVLink system.
#pragma once

#include <array>

#include "consoles.hpp"
#include "control.hpp"
#include "files.hpp"
#include "link.hpp"
#include "mavlink_ports.hpp"
#include "mission_transfer.hpp"
#include "parameter_transfer.hpp"
#include "router.hpp"
#include "signing.hpp"
#include "streams.hpp"
#include "telemetry.hpp"

namespace stator::apps::mavlink {

// Runs at a fixed period; in each activation it takes a bounded number of bytes from each line, and
// gives each a bounded number. Lines that are not open cost nothing. Everything that asks for an
// answer gets exactly one, on the line that it came from; what we do not do is UNSUPPORTED. Frames
// for others go on to the other line, unchanged.
//
// One command of the vehicle at a time is on its way to the node that decides; another one that
// comes meanwhile is TEMPORARILY_REJECTED.
class Mavlink {
  public:
    void step(MavlinkPorts& ports);

  private:
    static constexpr unsigned kLinks = 2;
    static constexpr unsigned kStreamsAtOnce = 8;  // of one line in an activation
    static constexpr uint8_t kComponent = 1;       // an autopilot's

    // A command in either of its two forms.
    struct Request {
        unsigned link;
        mav::Address from;
        uint16_t command;
        uint8_t frame;
        bool is_silent = false;
        std::array<float, 4> param;
        double latitude_deg;  // not a number: none
        double longitude_deg;
        float z;
    };
    // The one that the vehicle has been told, and that has no answer yet.
    struct Pending {
        bool is_one = false;
        bool is_silent = false;  // it came in a message that has no answer
        unsigned link = 0;
        mav::Address from;
        uint16_t command = 0;
        uint8_t tag = 0;
        uint64_t since_us = 0;
    };
    struct Line {
        Link link;
        Streams streams;
        // Modes that a station waits for: from this number on, below the other.
        uint8_t mode_next = 0;
        uint8_t mode_end = 0;
    };

    void configure(const MavlinkParams& params);
    void receive(unsigned number, Input<SerialBytes>& received, MavlinkPorts& ports);
    void handle(unsigned number, const mav::Frame& frame, MavlinkPorts& ports);
    void forward(unsigned from, const mav::Frame& frame);
    template <class Message>
    bool is_for_us(const Message& message) const;
    void tell_reached(const MavlinkPorts& ports);
    void tell_notices(MavlinkPorts& ports);
    void tell_due(unsigned number, const MavlinkPorts& ports);
    void send_waiting(unsigned number, Output<SerialBytes>& output);
    Link& link(unsigned number) { return lines_[number].link; }

    bool counts(unsigned number, const mav::Frame& frame, uint64_t now_us);
    void set_up_signing(unsigned number, const mav::Frame& frame, const MavlinkPorts& ports);

    // commands.cpp
    void handle_command(const Request& request, MavlinkPorts& ports);
    void handle_request_message(const Request& request, uint32_t id, MavlinkPorts& ports);
    void handle_request_modes(const Request& request);
    void handle_flight_command(const Request& request, MavlinkPorts& ports);
    void restart(const Request& request, MavlinkPorts& ports);
    void calibrate(const Request& request, MavlinkPorts& ports);
    void test_motor(const Request& request, float number, float thrust, float duration,
                    MavlinkPorts& ports);
    void set_mode(const Request& request, uint32_t main, uint32_t sub, MavlinkPorts& ports);
    void command(const Request& request, const VehicleCommand& wish, MavlinkPorts& ports);
    VehicleCommand go_to(const Request& request) const;
    void orbit(const Request& request, MavlinkPorts& ports);
    float height_of(float z, uint8_t frame) const;
    void answer(const Request& request, uint32_t outcome);
    void acknowledge(unsigned number, mav::Address to, uint16_t command, uint32_t outcome);
    void take_answers(MavlinkPorts& ports);

    std::array<Line, kLinks> lines_;
    Router router_;
    Signing signing_;
    Telemetry telemetry_;
    Control control_;
    MissionTransfer plans_;
    ParameterTransfer parameters_;
    Files files_;
    Consoles consoles_;
    mav::Address own_{1, kComponent};
    Pending pending_;
    int32_t reached_ = -1;  // the item that was told last
    uint64_t restarted_us_ = 0;
    uint64_t calibrated_us_ = 0;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::mavlink
