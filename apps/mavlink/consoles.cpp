// Consoles of ground stations.
#include "consoles.hpp"

#include <algorithm>
#include <string_view>

namespace stator::apps::mavlink {

namespace {

constexpr uint8_t kShell = 10;  // SERIAL_CONTROL_DEV_SHELL

mav::SerialControl reply_to(const mav::Address& station) {
    return {.device = kShell,
            .flags = static_cast<uint8_t>(mav::serial_control_flag::kReply),
            .target_system = station.system,
            .target_component = station.component};
}

void refuse(Link& link, const mav::Address& station, std::string_view why) {
    mav::SerialControl reply = reply_to(station);
    reply.count = static_cast<uint8_t>(std::min(why.size(), reply.data.size()));
    std::copy_n(why.begin(), reply.count, reply.data.begin());
    link.send(reply);
}

}  // namespace

bool Consoles::handle(Link& link, unsigned number, const mav::Frame& frame, MavlinkPorts& ports) {
    if (frame.id != mav::SerialControl::kId) return false;
    const auto m = mav::decode<mav::SerialControl>(frame.payload);
    const mav::Address own = link.own();
    const bool is_for_us = (m.target_system == 0 || m.target_system == own.system) &&
                           (m.target_component == 0 || m.target_component == own.component);
    if (!is_for_us || m.device != kShell || !ports.typed.is_connected()) return true;
    if ((m.flags & mav::serial_control_flag::kReply) != 0) return true;
    const bool is_end = m.count == 0 && (m.flags & mav::serial_control_flag::kRespond) == 0;
    Console* const console = find(number, frame.source, ports.now);
    if (console != nullptr && is_end) console->is_used = false;
    if (is_end) return true;
    if (link.role() == Role::kRadio || !link.allows(Right::kConsole)) {
        if (m.count != 0) refuse(link, frame.source, "no console on this line\n");
    } else if (console == nullptr) {
        if (m.count != 0) refuse(link, frame.source, "all consoles are in use: try in 10 s\n");
    } else {
        type(*console, m, ports);
    }
    return true;
}

// The station's own, else a free one, else one that was silent for long; null: there is none.
Consoles::Console* Consoles::find(unsigned number, const mav::Address& station, uint64_t now_us) {
    Console* chosen = nullptr;
    for (Console& console : consoles_) {
        if (console.is_used && console.line == number && console.station == station) {
            console.heard_us = now_us;
            return &console;
        }
        const bool is_free = !console.is_used || now_us - console.heard_us > kSilence_us;
        if (chosen == nullptr && is_free) chosen = &console;
    }
    if (chosen == nullptr) return nullptr;
    *chosen = {
        .is_used = true, .is_new = true, .line = number, .station = station, .heard_us = now_us};
    return chosen;
}

// A flood is cut: what one activation cannot take is lost.
void Consoles::type(Console& console, const mav::SerialControl& message, MavlinkPorts& ports) {
    if (message.count == 0 && !console.is_new) return;
    if (typed_left_ == 0) return;
    --typed_left_;
    ports.typed.publish([&] {
        ShellText typed{.console = static_cast<uint8_t>(&console - consoles_.data()),
                        .is_new = console.is_new};
        typed.length = std::min<uint8_t>(message.count, typed.data.size());
        std::copy_n(message.data.begin(), typed.length, typed.data.begin());
        return typed;
    });
    console.is_new = false;
    console.is_printing = true;
}

void Consoles::ask(MavlinkPorts& ports) {
    is_asking_ = true;
    asked_us_ = ports.now;
    ++tag_;
    ports.typed.publish([&] {
        return ShellText{.console = static_cast<uint8_t>(next_), .tag = tag_, .wants_text = true};
    });
}

void Consoles::take(const ShellText& printed) {
    if (!is_asking_ || printed.tag != tag_ || printed.console >= kConsoles) return;
    is_asking_ = false;
    Console& console = consoles_[printed.console];
    if (!console.is_used) return;
    console.is_printing = printed.has_more;
    held_ = printed;
    is_held_ = printed.length != 0;
}

bool Consoles::send_held(Link& link) {
    mav::SerialControl reply = reply_to(consoles_[held_.console].station);
    reply.count = std::min<uint8_t>(held_.length, reply.data.size());
    std::copy_n(held_.data.begin(), reply.count, reply.data.begin());
    return link.send(reply);
}

}  // namespace stator::apps::mavlink
