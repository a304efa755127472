// Puts transfers together from frames.
#include "stator/dronecan/receiver.hpp"

#include "stator/dronecan/crc.hpp"

namespace stator::dronecan {

namespace {

constexpr unsigned kCrcBytes = 2;
constexpr uint64_t kSecond_us = 1'000'000;

bool matches(const Header& header, const Wanted& wanted) {
    const DataType& type = wanted.type;
    if (header.kind != type.kind) return false;
    if (header.source != 0) return header.type_id == type.id;
    return wanted.anonymous && header.type_id == (type.id & 3);
}

// The index of the type that the frame belongs to; the number of types if it is of none.
unsigned find(std::span<const Wanted> wanted, const Header& header) {
    unsigned type = 0;
    while (type < wanted.size() && !matches(header, wanted[type])) ++type;
    return type;
}

}  // namespace

bool ReceiverCore::accept(const Storage& storage, const Frame& frame, uint64_t now_us) {
    const Header header = from_id(frame.id);
    const unsigned type = find(storage.wanted, header);
    if (type == storage.wanted.size()) return false;
    if (header.kind != DataType::Kind::kMessage && header.destination != own_id_) return false;
    if (!allowed_.has(header.source)) {
        ++counters_.refused;
        return false;
    }
    if (frame.length == 0 || frame.length > kMaxFrameBytes) {
        ++counters_.malformed;
        return false;
    }
    const uint8_t tail = frame.data[frame.length - 1];
    const bool starts = (tail & Tail::kStart) != 0;
    Session* const session = session_for(storage, header, type, starts, now_us);
    if (session == nullptr) return false;
    const Wanted& wanted = storage.wanted[type];
    if (!within_rate(*session, wanted.frames_per_second, now_us)) return false;
    if (!(starts ? start(*session, tail, now_us) : continues(*session, tail, now_us))) return false;

    const std::size_t most_bytes = storage.bytes.size() / storage.sessions.size();
    const auto index = static_cast<std::size_t>(session - storage.sessions.data());
    const std::span<uint8_t> room = storage.bytes.subspan(index * most_bytes, most_bytes);
    if (!take(*session, frame, room) || (tail & Tail::kEnd) == 0) return false;
    header_ = header;
    header_.type_id = wanted.type.id;
    return finish(*session, wanted, room);
}

// The session of this sender and type; for a start, a new one in place of one that has been silent.
Session* ReceiverCore::session_for(const Storage& storage, const Header& header, unsigned type,
                                   bool starts, uint64_t now_us) {
    Session* free = nullptr;
    for (Session& session : storage.sessions) {
        if (session.used && session.source == header.source && session.type == type) {
            return &session;
        }
        const bool silent = now_us - session.started_us > kTransferTimeout_us;
        if (free == nullptr && (!session.used || silent)) free = &session;
    }
    if (!starts) {
        ++counters_.malformed;
        return nullptr;
    }
    if (free == nullptr) {
        ++counters_.no_room;
        return nullptr;
    }
    if (free->open) ++counters_.broken_off;
    *free = {.started_us = now_us,
             .window_us = now_us,
             .type = static_cast<uint8_t>(type),
             .source = header.source,
             .used = true};
    return free;
}

bool ReceiverCore::within_rate(Session& session, uint16_t most, uint64_t now_us) {
    if (now_us - session.window_us >= kSecond_us) {
        session.window_us = now_us;
        session.frames = 0;
    }
    if (session.frames >= most) {
        ++counters_.over_rate;
        return false;
    }
    ++session.frames;
    return true;
}

bool ReceiverCore::start(Session& session, uint8_t tail, uint64_t now_us) {
    const auto transfer_id = static_cast<uint8_t>(tail & Tail::kTransferId);
    // Nodes without an id cannot keep count of theirs.
    const bool again = session.complete && session.source != 0 &&
                       transfer_id == session.transfer_id &&
                       now_us - session.started_us <= kTransferTimeout_us;
    if (again) {
        ++counters_.repeated;
        return false;
    }
    if (session.open) ++counters_.broken_off;
    const bool whole = (tail & Tail::kEnd) != 0;
    session.open = false;
    session.complete = false;
    if ((tail & Tail::kToggle) != 0 || (session.source == 0 && !whole)) {
        ++counters_.malformed;
        return false;
    }
    session.started_us = now_us;
    session.transfer_id = transfer_id;
    session.length = 0;
    session.several = !whole;
    session.toggle = true;
    session.open = true;
    return true;
}

bool ReceiverCore::continues(Session& session, uint8_t tail, uint64_t now_us) {
    if (!session.open || (tail & Tail::kTransferId) != session.transfer_id) {
        ++counters_.malformed;
        return false;
    }
    if (now_us - session.started_us > kTransferTimeout_us) {
        ++counters_.broken_off;
        session.open = false;
        return false;
    }
    // A controller may send a frame again that was received at the first try.
    if (((tail & Tail::kToggle) != 0) != session.toggle) {
        ++counters_.repeated;
        return false;
    }
    session.toggle = !session.toggle;
    return true;
}

// Adds the frame's bytes; the checksum in front of the first of several frames goes to `crc`.
bool ReceiverCore::take(Session& session, const Frame& frame, std::span<uint8_t> room) {
    const uint8_t tail = frame.data[frame.length - 1];
    const bool full = (tail & Tail::kEnd) != 0 || frame.length == kMaxFrameBytes;
    std::span<const uint8_t> bytes = std::span(frame.data).first(frame.length - 1U);
    if (full && session.several && (tail & Tail::kStart) != 0) {
        session.crc = static_cast<uint16_t>(bytes[0] | (bytes[1] << 8));
        bytes = bytes.subspan(kCrcBytes);
    }
    if (!full || session.length + bytes.size() > room.size()) {
        ++counters_.malformed;
        session.open = false;
        return false;
    }
    for (const uint8_t byte : bytes) room[session.length++] = byte;
    return true;
}

bool ReceiverCore::finish(Session& session, const Wanted& wanted, std::span<const uint8_t> room) {
    session.open = false;
    payload_ = room.first(session.length);
    if (session.length > wanted.type.most_bytes) {
        ++counters_.malformed;
        return false;
    }
    if (session.several && crc16(wanted.type.crc_seed, payload_) != session.crc) {
        ++counters_.wrong_crc;
        return false;
    }
    session.complete = true;
    transfer_id_ = session.transfer_id;
    begun_us_ = session.started_us;
    ++counters_.transfers;
    return true;
}

}  // namespace stator::dronecan
