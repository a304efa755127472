// Logs, as stations list and download them by MAVLink's LOG messages.
#pragma once

#include <array>
#include <span>

#include "file_source.hpp"
#include "link.hpp"

namespace stator::apps::mavlink {

// Each line has one list and one download at a time; a new request takes its place. A download ends
// at the size that the log had at its beginning, so that one of a log that grows has an end; the
// station asks for gaps again. Where the board cannot read logs, a station is told so, and that
// there are none.
class LogTransfer {
  public:
    static constexpr unsigned kLines = 2;

    // False: not a message about logs.
    bool handle(Link& link, unsigned number, const mav::Frame& frame);
    // What is to be asked next for a line that has room for the answer; false: nothing.
    template <class Lines>
    bool next_wish(Lines& lines, FileSource::Wish& wish) {
        for (unsigned i = 0; i < kLines; ++i) {
            turn_ = (turn_ + 1) % kLines;
            if (lines[turn_].link.has_room_for_bulk() && wants(jobs_[turn_], wish)) return true;
        }
        return false;
    }
    // The answer to the wish.
    template <class Lines>
    void take(Lines& lines, const FilePiece& piece) {
        Jobs& jobs = jobs_[turn_];
        if (jobs.ticket != ticket_) return;
        is_list_ ? list(jobs, lines[turn_].link, piece) : go_on(jobs, lines[turn_].link, piece);
    }

  private:
    static constexpr uint8_t kDataBytes = 90;  // of a message
    static constexpr uint8_t kPieceBytes = 2 * kDataBytes;

    struct Jobs {
        uint8_t ticket = 0;  // another one with each request
        // The list, from `next` to `last`, and then `first` again: a station takes the least number
        // that it heard for the first one.
        bool is_listing = false;
        bool is_last = false;
        uint16_t first = 0;
        uint16_t next = 0;
        uint16_t last = 0;
        // The download.
        bool is_sending = false;
        bool knows_end = false;
        uint16_t log = 0;
        uint32_t offset = 0;
        uint32_t count = 0;
        uint32_t end = 0;
        bool is_to_end = false;  // of the log
    };

    bool wants(Jobs& jobs, FileSource::Wish& wish);
    void list(Jobs& jobs, Link& link, const FilePiece& piece);
    void go_on(Jobs& jobs, Link& link, const FilePiece& piece);
    void send(Link& link, const Jobs& jobs, std::span<const uint8_t> data);

    std::array<Jobs, kLines> jobs_{};
    unsigned turn_ = 0;     // the line that was asked for last
    uint8_t ticket_ = 0;    // of what was asked for it
    bool is_list_ = false;  // whether that was for its list
};

}  // namespace stator::apps::mavlink
