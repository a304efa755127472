// What is told unasked, and how often.
#include "streams.hpp"

#include <algorithm>

#include "stator/scalar.hpp"

namespace stator::apps::mavlink {

namespace {

constexpr uint32_t kHeartbeatPeriod_us = 1'000'000;

std::size_t index_of(uint32_t id) {
    const auto found = std::ranges::find(kStreams, id, &Stream::id);
    return static_cast<std::size_t>(found - kStreams.begin());
}

}  // namespace

uint32_t Streams::usual_us(const Stream& stream, Role role) {
    return 1000U * (role == Role::kOnBoard ? stream.onboard_ms : stream.usual_ms);
}

void Streams::use(Role role) {
    role_ = role;
    for (std::size_t i = 0; i < kStreams.size(); ++i) {
        states_[i].interval_us = usual_us(kStreams[i], role);
    }
}

bool Streams::set(uint32_t id, float interval_us, uint64_t now_us) {
    const std::size_t index = index_of(id);
    if (index == kStreams.size()) return false;
    const uint32_t usual = usual_us(kStreams[index], role_);
    auto interval = math::saturate<uint32_t>(interval_us);
    if (interval_us == 0.0F) interval = usual;
    if (interval_us < 0.0F) interval = 0;
    if (interval != 0) interval = std::max(interval, static_cast<uint32_t>(kShortest_us));
    if (id == mav::Heartbeat::kId && (interval == 0 || interval > kHeartbeatPeriod_us)) {
        interval = kHeartbeatPeriod_us;
    }
    states_[index] = {.due_us = now_us, .interval_us = interval};
    return true;
}

int32_t Streams::interval_us(uint32_t id) const {
    const std::size_t index = index_of(id);
    if (index == kStreams.size()) return 0;
    const uint32_t interval = states_[index].interval_us;
    return interval == 0 ? -1 : static_cast<int32_t>(std::min<uint32_t>(interval, INT32_MAX));
}

uint16_t Streams::take_due(uint64_t now_us) {
    std::size_t chosen = kStreams.size();
    for (std::size_t i = 0; i < kStreams.size(); ++i) {
        const State& state = states_[i];
        if (state.interval_us == 0 || state.due_us > now_us) continue;
        if (chosen == kStreams.size() || state.due_us < states_[chosen].due_us) chosen = i;
    }
    if (chosen == kStreams.size()) return kNoStream;
    put_off(states_[chosen], now_us);
    return kStreams[chosen].id;
}

bool Streams::take(uint32_t id, uint64_t now_us) {
    const std::size_t index = index_of(id);
    if (index == kStreams.size()) return false;
    State& state = states_[index];
    if (state.interval_us == 0 || state.due_us > now_us) return false;
    put_off(state, now_us);
    return true;
}

void Streams::put_off(State& state, uint64_t now_us) {
    state.due_us += state.interval_us;
    if (state.due_us <= now_us) state.due_us = now_us + state.interval_us;  // it could not keep up
}

void Streams::hasten(uint32_t id, uint64_t now_us) {
    const std::size_t index = index_of(id);
    if (index < kStreams.size()) states_[index].due_us = std::min(states_[index].due_us, now_us);
}

}  // namespace stator::apps::mavlink
