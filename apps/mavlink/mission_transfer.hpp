// Plans (mission, fence, rally points) on their way from a station to the mission device and back.
#pragma once

#include <array>
#include <optional>

#include "link.hpp"
#include "mavlink_ports.hpp"

namespace stator::apps::mavlink {

// One upload at a time, of one station; to clear a list is to upload an empty one. Its items go to
// the device as they come; only its end makes the new plan count, whole. An item that does not come
// is asked for again, and after 5 s the upload is over and the plan is the one before. Downloads
// have no state but the newest questions of each line, in a row: the device is asked for each item.
// What a station is told goes to it alone.
class MissionTransfer {
  public:
    // False: not a message of a plan.
    bool handle(Link& link, unsigned number, const mav::Frame& frame, MavlinkPorts& ports);
    // Once in each activation, behind all messages: `links` are all lines.
    template <class Lines>
    void step(Lines& lines, MavlinkPorts& ports) {
        take_items(ports);
        for (unsigned i = 0; i < lines.size(); ++i) {
            answer_download(lines[i].link, i, ports);
            if (upload_.is_one && upload_.line == i) go_on(lines[i].link, ports);
        }
    }

  private:
    static constexpr unsigned kLists = 3;
    static constexpr unsigned kLines = 2;
    static constexpr uint64_t kAskAgain_us = 250'000;
    // Between questions. The device takes what came in 100 ms at once, from a queue of 8.
    static constexpr uint64_t kAskNext_us = 20'000;
    static constexpr uint64_t kPatience_us = 5'000'000;
    static constexpr uint64_t kKept_us = 2'000'000;  // until the device must have it
    static constexpr uint64_t kRepeated_us = 100'000;

    struct Upload {
        bool is_one = false;
        bool is_committed = false;
        unsigned line = 0;
        mav::Address from;
        uint8_t list = 0;
        uint8_t last = 0;  // list, where several are cleared
        uint8_t told = 0;  // list, as the station named it
        uint16_t count = 0;
        uint16_t next = 0;
        bool is_asked = false;  // for the next one
        uint32_t refused = 0;   // of the device, before it
        uint64_t begun_us = 0;
        uint64_t heard_us = 0;
        uint64_t asked_us = 0;
        // Of the one that has ended.
        uint32_t outcome = 0;
        uint32_t opaque_id = 0;
    };
    struct Download {
        bool is_one = false;
        bool is_float = false;  // as old stations ask for it
        mav::Address to;
        uint8_t list = 0;
        uint16_t index = 0;
        uint16_t last = 0;  // some stations ask for several items at once
        uint64_t asked_us = 0;
    };

    void begin(Link& link, unsigned line, mav::Address from, const mav::MissionCount& count,
               MavlinkPorts& ports);
    void take(Link& link, mav::Address from, const mav::MissionItemInt& item, MavlinkPorts& ports);
    void ask_next(Link& link, uint64_t now_us);
    void go_on(Link& link, MavlinkPorts& ports);
    void end(Link& link, uint32_t outcome, uint32_t opaque_id);
    void tell_count(Link& link, mav::Address to, uint8_t list, const MavlinkPorts& ports) const;
    void ask_device(unsigned line, mav::Address to, uint8_t list, uint16_t index, bool is_float,
                    Link& link, MavlinkPorts& ports);
    void take_items(MavlinkPorts& ports);
    void answer_download(Link& link, unsigned line, MavlinkPorts& ports);
    void clear(Link& link, unsigned line, mav::Address from, uint8_t list, MavlinkPorts& ports);
    void open_list(MavlinkPorts& ports);
    static void acknowledge(Link& link, mav::Address to, uint8_t list, uint32_t outcome,
                            uint32_t opaque_id = 0);

    Upload upload_;
    std::array<Download, kLines> downloads_{};
    std::array<std::optional<MissionItem>, 2> items_{};  // the newest of the device
    unsigned newest_ = 0;
    uint64_t asked_in_ = 0;  // the activation in which the device was asked last
};

}  // namespace stator::apps::mavlink
