// A simulated serial line between two machines.
#include "world/wire.hpp"

#include <algorithm>
#include <utility>

namespace stator::world {

void Wire::send(unsigned end, std::span<const std::uint8_t> frame, std::uint64_t now_us) {
    Side& side = sides_[end];
    side.is_sending = true;
    side.frame.assign(frame.begin(), frame.end());
    const std::uint64_t bits = kBitsOfByte * frame.size();
    side.end_us = now_us + kGap_us + (bits * 1'000'000 + baud_ - 1) / baud_;
}

void Wire::stop(unsigned end) {
    sides_[end].is_sending = false;
    sides_[end].arrivals.clear();
}

void Wire::set_faults(bool is_cut, double noise) {
    is_cut_ = is_cut;
    noise_ = noise;
}

std::uint64_t Wire::next_event_us() const {
    std::uint64_t next = kNever;
    for (const Side& side : sides_) {
        if (side.is_sending) next = std::min(next, side.end_us);
        if (!side.arrivals.empty()) next = std::min(next, side.arrivals.front().at_us);
    }
    return next;
}

Wire::Event Wire::take() {
    const std::uint64_t now_us = next_event_us();
    for (unsigned end = 0; end < kEnds; ++end) {
        Side& side = sides_[end];
        if (!side.arrivals.empty() && side.arrivals.front().at_us == now_us) {
            Event event{Event::Kind::kArrival, end, std::move(side.arrivals.front().bytes)};
            side.arrivals.pop_front();
            return event;
        }
    }
    return finish(sides_[0].is_sending && sides_[0].end_us == now_us ? 0 : 1);
}

Wire::Event Wire::finish(unsigned end) {
    Side& side = sides_[end];
    side.is_sending = false;
    const unsigned far = 1 - end;
    // Drawn for each frame, whatever becomes of it, so that a fault changes nothing else.
    const std::uint64_t wait_us = random_.word() % (wake_up_us_[far] + 1);
    if (!is_cut_) {
        damage(side.frame);
        std::deque<Arrival>& arrivals = sides_[far].arrivals;
        const std::uint64_t before_us = arrivals.empty() ? 0 : arrivals.back().at_us;
        arrivals.push_back({std::max(before_us, side.end_us + wait_us), side.frame});
    }
    return {Event::Kind::kSent, end, {}};
}

void Wire::damage(std::vector<std::uint8_t>& bytes) {
    if (noise_ <= 0.0) return;
    for (std::uint8_t& byte : bytes) {
        if (random_.uniform_double() >= noise_) continue;
        byte = static_cast<std::uint8_t>(byte ^ (1U << (random_.word() % 8)));
    }
}

}  // namespace stator::world
