// MAVLink's file transfer (FTP): a tree of files that can be read, and nothing else.
#pragma once

#include <array>
#include <span>

#include "file_source.hpp"
#include "link.hpp"

namespace stator::apps::mavlink {

// A session is known by its station and by the number that the station gave it, and answers go out
// with that number. A file is as it was when it was opened: its size counts until the end, and
// where its contents change, reading ends with an error. All requests can be repeated, so no answer
// is stored. A burst sends a bounded number of pieces, and says so in its last one.
class FileTransfer {
  public:
    static constexpr unsigned kSessions = 4;
    static constexpr uint16_t kBurstPieces = 100;

    // False: not a message of file transfer.
    bool handle(Link& link, unsigned number, const mav::Frame& frame, uint64_t now_us);
    // What is to be asked next for a station whose line has room for the answer; false: nothing.
    template <class Lines>
    bool next_wish(Lines& lines, FileSource::Wish& wish) {
        for (unsigned i = 0; i < kSessions; ++i) {
            turn_ = (turn_ + 1) % kSessions;
            Session& session = sessions_[turn_];
            Link& link = lines[session.line].link;
            if (session.is_one && link.has_room_for_bulk() && wants(session, link, wish)) {
                return true;
            }
        }
        return false;
    }
    // The answer to the wish.
    template <class Lines>
    void take(Lines& lines, const FilePiece& piece) {
        Session& session = sessions_[turn_];
        if (!session.is_one || session.ticket != ticket_)
            return;  // the station wants another thing
        answer(session, lines[session.line].link, piece);
    }

  private:
    static constexpr uint64_t kIdle_us = 10'000'000;
    static constexpr std::size_t kHeaderBytes = 12;
    static constexpr std::size_t kDataBytes = 239;

    enum class Opcode : uint8_t {
        kNone = 0,
        kTerminate = 1,
        kReset = 2,
        kList = 3,
        kOpen = 4,
        kRead = 5,
        kCreateFile = 6,
        kRename = 13,
        kCrc = 14,
        kBurst = 15,
        kDone = 128,
        kRefused = 129,
    };
    enum class Error : uint8_t {
        kFailed = 1,
        kDataSize = 3,
        kSession = 4,
        kNoSession = 5,
        kEnd = 6,
        kUnknown = 7,
        kProtected = 9,
        kAbsent = 10,
    };

    // A request without its data, or the head of an answer.
    struct Head {
        uint16_t sequence = 0;
        uint8_t session = 0;
        Opcode opcode = Opcode::kNone;
        uint8_t size = 0;
        uint32_t offset = 0;
    };
    // A line of a list: of a folder ('D') or a file ('F').
    struct Listed {
        char kind;
        std::string_view name;
        uint32_t bytes = 0;
    };
    struct Session {
        bool is_one = false;
        unsigned line = 0;
        mav::Address peer{};
        uint8_t number = 0;
        uint64_t heard_us = 0;
        // The file that is open.
        File file{};
        uint32_t bytes = 0;
        uint32_t version = 0;
        // The request that waits for its answer, and what it is about.
        Head request{};
        Folder folder = Folder::kNone;
        File wanted{};
        uint32_t crc = 0;
        uint8_t ticket = 0;
        // The burst, which goes on behind other requests.
        Head burst{};
        uint16_t pieces_left = 0;
    };

    void start(Session& session, Link& link, const Head& request, std::string_view path);
    Session* find(mav::Address peer, uint8_t number);
    Session* make(mav::Address peer, uint8_t number, uint64_t now_us);
    bool wants(Session& session, Link& link, FileSource::Wish& wish);
    bool wants_entry(Session& session, Link& link, FileSource::Wish& wish);
    void answer(Session& session, Link& link, const FilePiece& piece);
    void answer_request(Session& session, Link& link, const FilePiece& piece);
    void go_on(Session& session, Link& link, const FilePiece& piece);
    void tell(Link& link, const Session& session, const Head& request,
              std::span<const uint8_t> data, bool is_last_of_burst = false);
    void tell_entry(Link& link, const Session& session, const Head& request, const Listed& listed);
    void end(Session& session) { session.request.opcode = Opcode::kNone; }
    void refuse(Link& link, mav::Address to, const Head& request, Error error);
    void send(Link& link, mav::Address to, const Head& request, Opcode opcode,
              std::span<const uint8_t> data, bool is_last_of_burst = false);
    static bool is_idle(const Session& session) {
        return session.file.kind == File::Kind::kNone && session.request.opcode == Opcode::kNone;
    }

    std::array<Session, kSessions> sessions_{};
    unsigned turn_ = 0;      // the session that was asked for last
    uint8_t ticket_ = 0;     // of what was asked for it
    bool is_burst_ = false;  // whether that was for its burst
    uint8_t tickets_ = 0;
};

}  // namespace stator::apps::mavlink
