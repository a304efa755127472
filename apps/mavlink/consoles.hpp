// Consoles of ground stations: SERIAL_CONTROL on the way to the vehicle's shell and back.
#pragma once

#include <array>

#include "link.hpp"
#include "mavlink_ports.hpp"

namespace stator::apps::mavlink {

// Each station has a console of its own, which it loses to another one after it was silent for a
// while. What is typed goes to the shell at once; what is to be printed is asked for piece by
// piece, as far as the line has room, so that nothing of it is lost. A line of a radio has no
// console.
class Consoles {
  public:
    // False: not a message for a console.
    bool handle(Link& link, unsigned number, const mav::Frame& frame, MavlinkPorts& ports);
    // Once in each activation, behind all messages: `lines` are all lines.
    template <class Lines>
    void step(Lines& lines, MavlinkPorts& ports) {
        while (ports.printed.next()) take(*ports.printed);
        if (is_held_ && send_held(lines[consoles_[held_.console].line].link)) is_held_ = false;
        if (is_asking_ && ports.now - asked_us_ > kPatience_us) is_asking_ = false;
        typed_left_ = kTypedAtOnce;
        for (unsigned i = 0; i < kConsoles && !is_asking_ && !is_held_; ++i) {
            next_ = (next_ + 1) % kConsoles;
            const Console& console = consoles_[next_];
            if (!console.is_printing || !lines[console.line].link.has_room_for_bulk()) continue;
            ask(ports);
        }
    }

  private:
    static constexpr unsigned kConsoles = 2;     // as many as the shell has
    static constexpr unsigned kTypedAtOnce = 4;  // pieces in an activation, for all
    static constexpr uint64_t kSilence_us = 10'000'000;
    static constexpr uint64_t kPatience_us = 500'000;

    struct Console {
        bool is_used = false;
        bool is_new = false;       // nothing was typed yet
        bool is_printing = false;  // the shell may have text for it
        unsigned line = 0;
        mav::Address station{};
        uint64_t heard_us = 0;
    };

    Console* find(unsigned number, const mav::Address& station, uint64_t now_us);
    void type(Console& console, const mav::SerialControl& message, MavlinkPorts& ports);
    void ask(MavlinkPorts& ports);
    void take(const ShellText& printed);
    bool send_held(Link& link);

    std::array<Console, kConsoles> consoles_{};
    ShellText held_{};  // until the line takes it
    bool is_held_ = false;
    bool is_asking_ = false;
    uint64_t asked_us_ = 0;
    uint8_t tag_ = 0;
    unsigned next_ = 0;
    unsigned typed_left_ = kTypedAtOnce;
};

}  // namespace stator::apps::mavlink
