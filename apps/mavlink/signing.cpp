// Which frames count by their signatures.
#include "signing.hpp"

#include <algorithm>
#include <cstring>

namespace stator::apps::mavlink {

namespace {

// What comes unsigned from who cannot sign: radios, and receivers of other aircraft.
constexpr uint32_t kAdsbVehicle = 246;
constexpr uint32_t kCollision = 247;

bool is_always_taken(uint32_t id) {
    return id == mav::RadioStatus::kId || id == kAdsbVehicle || id == kCollision;
}

}  // namespace

void Signing::step(bool signs, MavlinkPorts& ports) {
    while (ports.stored.next()) {
        const StoredRecord& record = *ports.stored;
        if (record.kind != StoredRecord::Kind::kSigningTime || record.length != sizeof bound_) {
            continue;
        }
        std::memcpy(&bound_, record.data.data(), sizeof bound_);
        see(bound_, ports.now);
    }
    const bool is_near = time(ports.now) + kKeepsBefore > bound_;
    if (forgets_ || (signs && is_near && ports.now - kept_us_ >= kRetry_us)) keep(ports);
}

void Signing::keep(MavlinkPorts& ports) {
    kept_us_ = ports.now;
    bound_ = forgets_ ? 0 : time(ports.now) + kAhead;
    const uint8_t length = forgets_ ? 0 : sizeof bound_;
    forgets_ = false;
    if (!ports.store.is_connected()) return;
    ports.store.publish([&] {
        StoredRecord record{.kind = StoredRecord::Kind::kSigningTime, .length = length};
        std::memcpy(record.data.data(), &bound_, length);
        return record;
    });
}

void Signing::restart(std::optional<uint64_t> time, uint64_t now_us) {
    streams_ = {};
    if (time) {
        see(*time, now_us);
        bound_ = 0;  // keep it at once
        return;
    }
    offset_ = 0;
    forgets_ = true;
}

bool Signing::takes_time(const mav::Frame& frame, uint64_t now_us) {
    const uint64_t sent = mav::time_of(frame.bytes);
    const uint8_t link = mav::link_of(frame.bytes);
    Stream* free = nullptr;
    for (Stream& stream : streams_) {
        if (!stream.is_used) {
            if (free == nullptr) free = &stream;
        } else if (stream.from == frame.source && stream.link == link) {
            if (sent <= stream.time) return false;
            stream.time = sent;
            see(sent, now_us);
            return true;
        }
    }
    if (free == nullptr || sent + kOldest < time(now_us)) return false;
    *free = {.from = frame.source, .link = link, .is_used = true, .time = sent};
    see(sent, now_us);
    return true;
}

bool Signing::takes(const mav::Frame& frame, bool may_be_unsigned, uint64_t now_us) {
    if (frame.is_signed) return takes_time(frame, now_us);
    return may_be_unsigned || is_always_taken(frame.id);
}

}  // namespace stator::apps::mavlink
