// Plans on their way from a station to the mission device and back.
#include "mission_transfer.hpp"

#include <algorithm>
#include <string_view>

#include "stator/scalar.hpp"

namespace stator::apps::mavlink {

namespace {

namespace result = mav::mav_mission_result;
namespace frames = mav::mav_frame;

constexpr uint8_t kFence = 1;
constexpr uint8_t kRally = 2;
constexpr uint8_t kAllLists = 255;
constexpr std::array<uint16_t, 3> kMost{10'000, 128, 16};  // of the mission device
constexpr int32_t kMaxLatitude = 900'000'000;
constexpr int32_t kMaxLongitude = 1'800'000'000;

// What the navigator flies or does, and what stays in a mission as a mark or for a camera's
// trigger, in order.
constexpr std::array<uint16_t, 31> kMissionCommands{
    16,  17,  18,  19,  20,  21,  22,  30,  31,  35,  80,  82,  84,   85,   93,  112,
    113, 114, 115, 177, 178, 189, 195, 197, 201, 206, 211, 600, 2000, 2001, 5100};
constexpr std::array<uint16_t, 5> kFenceCommands{5000, 5001, 5002, 5003, 5004};

bool is_command_of(uint8_t list, uint16_t command) {
    if (list == kRally) return command == mav::mav_cmd::kNavRallyPoint;
    if (list == kFence) return std::ranges::find(kFenceCommands, command) != kFenceCommands.end();
    return command != mav::mav_cmd::kNavRallyPoint &&
           std::ranges::binary_search(kMissionCommands, command);
}

bool is_place_frame(uint8_t frame) {
    return frame == frames::kGlobal || frame == frames::kGlobalInt ||
           frame == frames::kGlobalRelativeAlt || frame == frames::kGlobalRelativeAltInt;
}

// Why an item is refused; accepted: it is not.
uint32_t verdict(uint8_t list, const mav::MissionItemInt& item) {
    const bool is_place = is_place_frame(item.frame);
    if (!is_command_of(list, item.command)) return result::kUnsupported;
    if (!is_place && (item.frame != frames::kMission || list != 0))
        return result::kUnsupportedFrame;
    if (!is_place) return result::kAccepted;
    const auto is_beyond = [](int32_t value, int32_t most) {
        return value != INT32_MAX && (value > most || value < -most);
    };
    if (is_beyond(item.x, kMaxLatitude)) return result::kInvalidParam5X;
    if (is_beyond(item.y, kMaxLongitude)) return result::kInvalidParam6Y;
    if (math::abs(item.z) > 1e5F) return result::kInvalidParam7;
    return result::kAccepted;
}

uint32_t id_of(const Mission& mission, uint8_t list) {
    if (list == kFence) return mission.geofence_id;
    return list == kRally ? mission.safe_points_id : mission.mission_id;
}

uint16_t count_of(const Mission& mission, uint8_t list) {
    if (list == kFence) return mission.geofence_count;
    return list == kRally ? mission.safe_points_count : mission.count;
}

mav::MissionItemInt as_int(const mav::MissionItem& item) {
    const auto e7 = [](float degrees) {
        return math::saturate<int32_t>(math::round(static_cast<double>(degrees) * 1e7));
    };
    return {.param1 = item.param1,
            .param2 = item.param2,
            .param3 = item.param3,
            .param4 = item.param4,
            .x = is_place_frame(item.frame) ? e7(item.x) : math::saturate<int32_t>(item.x),
            .y = is_place_frame(item.frame) ? e7(item.y) : math::saturate<int32_t>(item.y),
            .z = item.z,
            .seq = item.seq,
            .command = item.command,
            .target_system = item.target_system,
            .target_component = item.target_component,
            .frame = item.frame,
            .current = item.current,
            .autocontinue = item.autocontinue,
            .mission_type = item.mission_type};
}

// "item 3: command 530 is not supported", for people.
void tell_refusal(Link& link, const mav::MissionItemInt& item) {
    mav::Statustext text{.severity = mav::mav_severity::kWarning};
    std::size_t at = 0;
    const auto write = [&](std::string_view words) {
        for (const char c : words) text.text[at++] = c;
    };
    const auto number = [&](uint32_t value) {
        std::array<char, 10> digits{};
        std::size_t count = 0;
        do digits[count++] = static_cast<char>('0' + value % 10);
        while ((value /= 10) != 0);
        while (count != 0) text.text[at++] = digits[--count];
    };
    write("item ");
    number(item.seq);
    write(" refused: command ");
    number(item.command);
    write(", frame ");
    number(item.frame);
    link.send(text);
}

template <class Message>
bool is_for(const Message& message, mav::Address own) {
    return message.target_system == own.system &&
           (message.target_component == own.component || message.target_component == 0);
}

}  // namespace

void MissionTransfer::acknowledge(Link& link, mav::Address to, uint8_t list, uint32_t outcome,
                                  uint32_t opaque_id) {
    mav::MissionAck ack{.target_system = to.system,
                        .target_component = to.component,
                        .type = static_cast<uint8_t>(outcome)};
    ack.mission_type = list;
    ack.opaque_id = opaque_id;
    link.send(ack);
}

void MissionTransfer::end(Link& link, uint32_t outcome, uint32_t opaque_id) {
    acknowledge(link, upload_.from, upload_.told, outcome, opaque_id);
    upload_.is_one = false;
    upload_.outcome = outcome;
    upload_.opaque_id = opaque_id;
}

void MissionTransfer::ask_next(Link& link, uint64_t now_us) {
    upload_.asked_us = now_us;
    upload_.is_asked = true;
    mav::MissionRequestInt request{.seq = upload_.next,
                                   .target_system = upload_.from.system,
                                   .target_component = upload_.from.component};
    request.mission_type = upload_.list;
    link.send(request);
}

// A count that is repeated at once, by the same station, is one.
void MissionTransfer::begin(Link& link, unsigned line, mav::Address from,
                            const mav::MissionCount& count, MavlinkPorts& ports) {
    const uint8_t list = count.mission_type;
    if (!ports.upload.is_connected() || list >= kLists) {
        return acknowledge(link, from, list, result::kUnsupported);
    }
    if (upload_.is_one) {
        const bool is_same = upload_.from == from && upload_.line == line;
        if (!is_same) return acknowledge(link, from, list, result::kDenied);
        if (upload_.list == list && ports.now - upload_.begun_us < kRepeated_us) return;
    }
    if (count.count > kMost[list]) return acknowledge(link, from, list, result::kNoSpace);
    upload_ = {.is_one = true,
               .line = line,
               .from = from,
               .list = list,
               .last = list,
               .told = list,
               .count = count.count,
               .begun_us = ports.now};
    open_list(ports);
    if (count.count != 0) ask_next(link, ports.now);
}

void MissionTransfer::open_list(MavlinkPorts& ports) {
    upload_.is_committed = false;
    upload_.refused = ports.mission ? ports.mission->refused : 0;
    upload_.heard_us = ports.now;
    ports.upload.publish([&] {
        return MissionUpload{.action = MissionUpload::Action::kBegin,
                             .list = static_cast<MissionUpload::List>(upload_.list),
                             .count = upload_.count};
    });
}

// What is not the next item, or was not asked for, is not taken: it is asked for again. So a
// station that answers fast, or unasked, cannot hand over more than the device takes. An item of an
// upload that has ended says that the station did not hear how: it is told again.
void MissionTransfer::take(Link& link, mav::Address from, const mav::MissionItemInt& item,
                           MavlinkPorts& ports) {
    const bool is_ours =
        upload_.from == from && upload_.list == item.mission_type && item.seq < upload_.count;
    if (!is_ours) return;
    if (!upload_.is_one) return end(link, upload_.outcome, upload_.opaque_id);
    if (upload_.is_committed) return;
    if (item.seq != upload_.next || !upload_.is_asked) return;
    const uint32_t outcome = verdict(upload_.list, item);
    if (outcome != result::kAccepted) {
        tell_refusal(link, item);
        return end(link, outcome, 0);
    }
    upload_.heard_us = ports.now;
    ports.upload.publish([&] {
        MissionUpload part{.action = MissionUpload::Action::kItems,
                           .list = static_cast<MissionUpload::List>(upload_.list),
                           .first = item.seq,
                           .count = 1};
        part.command[0] = item.command;
        part.frame[0] = item.frame;
        part.autocontinue[0] = item.autocontinue;
        part.param1[0] = item.param1;
        part.param2[0] = item.param2;
        part.param3[0] = item.param3;
        part.param4[0] = item.param4;
        part.x[0] = item.x;
        part.y[0] = item.y;
        part.z[0] = item.z;
        return part;
    });
    ++upload_.next;
    upload_.is_asked = false;
}

// Asks again, commits, and tells what became of it.
void MissionTransfer::go_on(Link& link, MavlinkPorts& ports) {
    if (upload_.is_committed) {
        if (ports.mission.is_new()) {
            const bool is_kept = ports.mission->refused == upload_.refused;
            if (is_kept && upload_.list != upload_.last) {
                ++upload_.list;
                return open_list(ports);
            }
            return end(link, is_kept ? result::kAccepted : result::kError,
                       id_of(*ports.mission, upload_.list));
        }
        if (ports.now - upload_.heard_us > kKept_us) end(link, result::kError, 0);
        return;
    }
    if (upload_.next == upload_.count) {
        upload_.is_committed = true;
        upload_.heard_us = ports.now;
        ports.upload.publish([&] {
            return MissionUpload{.action = MissionUpload::Action::kCommit,
                                 .list = static_cast<MissionUpload::List>(upload_.list)};
        });
        return;
    }
    if (ports.now - upload_.heard_us > kPatience_us) {
        return end(link, result::kOperationCancelled, 0);
    }
    const uint64_t pause_us = upload_.is_asked ? kAskAgain_us : kAskNext_us;
    if (ports.now - upload_.asked_us >= pause_us) ask_next(link, ports.now);
}

void MissionTransfer::tell_count(Link& link, mav::Address to, uint8_t list,
                                 const MavlinkPorts& ports) const {
    if (list >= kLists) return acknowledge(link, to, list, result::kUnsupported);
    mav::MissionCount count{.target_system = to.system, .target_component = to.component};
    if (ports.mission) {
        count.count = count_of(*ports.mission, list);
        count.opaque_id = id_of(*ports.mission, list);
    }
    count.mission_type = list;
    link.send(count);
}

void MissionTransfer::ask_device(unsigned line, mav::Address to, uint8_t list, uint16_t index,
                                 bool is_float, Link& link, MavlinkPorts& ports) {
    const uint16_t count = ports.mission && list < kLists ? count_of(*ports.mission, list) : 0;
    if (index >= count) return acknowledge(link, to, list, result::kInvalidSequence);
    Download& wanted = downloads_[line];
    const bool goes_on = wanted.is_one && wanted.to == to && wanted.list == list &&
                         wanted.is_float == is_float && index >= wanted.index &&
                         index <= wanted.last + 1;
    if (goes_on) {
        wanted.last = std::max(wanted.last, index);
        return;
    }
    wanted = {.is_one = true,
              .is_float = is_float,
              .to = to,
              .list = list,
              .index = index,
              .last = index};
}

void MissionTransfer::take_items(MavlinkPorts& ports) {
    while (ports.downloaded.next()) {
        items_[newest_] = *ports.downloaded;
        newest_ = 1 - newest_;
    }
}

// From what the device said last, if that is of the plan as it is now; else the device is asked.
void MissionTransfer::answer_download(Link& link, unsigned line, MavlinkPorts& ports) {
    Download& wanted = downloads_[line];
    if (!wanted.is_one || !ports.mission) return;
    for (const auto& item : items_) {
        const bool is_it = item && item->index == wanted.index &&
                           static_cast<uint8_t>(item->list) == wanted.list &&
                           item->id == id_of(*ports.mission, wanted.list);
        if (!is_it) continue;
        wanted.is_one = wanted.index != wanted.last;
        ++wanted.index;
        wanted.asked_us = 0;
        mav::MissionItemInt answer{.param1 = item->param1,
                                   .param2 = item->param2,
                                   .param3 = item->param3,
                                   .param4 = item->param4,
                                   .x = item->x,
                                   .y = item->y,
                                   .z = item->z,
                                   .seq = item->index,
                                   .command = item->command,
                                   .target_system = wanted.to.system,
                                   .target_component = wanted.to.component,
                                   .frame = item->frame,
                                   .autocontinue = item->autocontinue};
        answer.mission_type = wanted.list;
        if (!wanted.is_float) {
            link.send(answer);
            return;
        }
        const bool is_place = is_place_frame(item->frame);
        const auto degrees = [is_place](int32_t value) {
            const auto number = static_cast<double>(value);
            return static_cast<float>(is_place ? number * 1e-7 : number);
        };
        mav::MissionItem old{.param1 = answer.param1,
                             .param2 = answer.param2,
                             .param3 = answer.param3,
                             .param4 = answer.param4,
                             .x = degrees(answer.x),
                             .y = degrees(answer.y),
                             .z = answer.z,
                             .seq = answer.seq,
                             .command = answer.command,
                             .target_system = answer.target_system,
                             .target_component = answer.target_component,
                             .frame = answer.frame,
                             .autocontinue = answer.autocontinue};
        old.mission_type = wanted.list;
        link.send(old);
        return;
    }
    if (wanted.asked_us != 0 && ports.now - wanted.asked_us < kAskAgain_us) return;
    if (asked_in_ == ports.now) return;  // one question in an activation
    asked_in_ = ports.now;
    wanted.asked_us = ports.now;
    ports.download.publish([&] {
        return MissionRequest{.first = wanted.index,
                              .list = static_cast<MissionRequest::List>(wanted.list)};
    });
}

void MissionTransfer::clear(Link& link, unsigned line, mav::Address from, uint8_t list,
                            MavlinkPorts& ports) {
    if (!ports.upload.is_connected() || (list >= kLists && list != kAllLists)) {
        return acknowledge(link, from, list, result::kUnsupported);
    }
    if (upload_.is_one) {
        const bool is_same = upload_.from == from && upload_.line == line && upload_.told == list;
        if (!is_same) acknowledge(link, from, list, result::kDenied);
        return;
    }
    upload_ = {.is_one = true,
               .line = line,
               .from = from,
               .list = list == kAllLists ? uint8_t{0} : list,
               .last = list == kAllLists ? uint8_t{kLists - 1} : list,
               .told = list,
               .begun_us = ports.now};
    open_list(ports);
}

bool MissionTransfer::handle(Link& link, unsigned number, const mav::Frame& frame,
                             MavlinkPorts& ports) {
    const auto read = [&]<class Message>(Message& message) {
        message = mav::decode<Message>(frame.payload);
        return is_for(message, link.own());
    };
    const auto is_allowed = [&](uint8_t list) {
        const bool may_plan = link.allows(Right::kPlan);
        if (!may_plan) acknowledge(link, frame.source, list, result::kDenied);
        return may_plan;
    };
    switch (frame.id) {
        case mav::MissionCount::kId: {
            mav::MissionCount count;
            if (read(count) && is_allowed(count.mission_type))
                begin(link, number, frame.source, count, ports);
            return true;
        }
        case mav::MissionItemInt::kId: {
            mav::MissionItemInt item;
            if (read(item)) take(link, frame.source, item, ports);
            return true;
        }
        case mav::MissionItem::kId: {
            mav::MissionItem item;
            if (read(item)) take(link, frame.source, as_int(item), ports);
            return true;
        }
        case mav::MissionRequestList::kId: {
            mav::MissionRequestList list;
            if (read(list)) tell_count(link, frame.source, list.mission_type, ports);
            return true;
        }
        case mav::MissionRequestInt::kId: {
            mav::MissionRequestInt wanted;
            if (!read(wanted)) return true;
            ask_device(number, frame.source, wanted.mission_type, wanted.seq, false, link, ports);
            return true;
        }
        case mav::MissionRequest::kId: {
            mav::MissionRequest wanted;
            if (!read(wanted)) return true;
            ask_device(number, frame.source, wanted.mission_type, wanted.seq, true, link, ports);
            return true;
        }
        case mav::MissionClearAll::kId: {
            mav::MissionClearAll all;
            if (read(all) && is_allowed(all.mission_type))
                clear(link, number, frame.source, all.mission_type, ports);
            return true;
        }
        case mav::MissionAck::kId: {
            mav::MissionAck ack;  // a station that gives its upload up
            if (read(ack) && upload_.is_one && upload_.from == frame.source &&
                ack.type != result::kAccepted && ack.mission_type == upload_.list) {
                upload_.is_one = false;
            }
            return true;
        }
        case mav::MissionRequestPartialList::kId: {
            mav::MissionRequestPartialList part;
            if (read(part))
                acknowledge(link, frame.source, part.mission_type, result::kUnsupported);
            return true;
        }
        case mav::MissionWritePartialList::kId: {
            mav::MissionWritePartialList part;
            if (read(part))
                acknowledge(link, frame.source, part.mission_type, result::kUnsupported);
            return true;
        }
        default:
            return false;
    }
}

}  // namespace stator::apps::mavlink
