// MAVLink's file transfer (FTP).
#include "file_transfer.hpp"

#include <algorithm>
#include <cstring>

#include "stator/crc32.hpp"

namespace stator::apps::mavlink {

namespace {

// Places in a message.
constexpr std::size_t kSession = 2;
constexpr std::size_t kOpcode = 3;
constexpr std::size_t kSize = 4;
constexpr std::size_t kAnswers = 5;
constexpr std::size_t kLastOfBurst = 6;
constexpr std::size_t kOffset = 8;

std::array<uint8_t, 4> bytes_of(uint32_t value) {
    std::array<uint8_t, 4> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

// In decimal, behind `at`.
uint8_t* put_number(uint8_t* at, uint32_t value) {
    uint8_t* const begin = at;
    do {
        *at++ = static_cast<uint8_t>('0' + value % 10);
        value /= 10;
    } while (value != 0);
    std::reverse(begin, at);
    return at;
}

}  // namespace

bool FileTransfer::handle(Link& link, unsigned number, const mav::Frame& frame, uint64_t now_us) {
    if (frame.id != mav::FileTransferProtocol::kId) return false;
    const auto message = mav::decode<mav::FileTransferProtocol>(frame.payload);
    const mav::Address own = link.own();
    const bool is_for_us =
        (message.target_system == 0 || message.target_system == own.system) &&
        (message.target_component == 0 || message.target_component == own.component);
    if (!is_for_us) return true;
    Head request{.session = message.payload[kSession],
                 .opcode = static_cast<Opcode>(message.payload[kOpcode]),
                 .size = message.payload[kSize]};
    std::memcpy(&request.sequence, message.payload.data(), sizeof request.sequence);
    std::memcpy(&request.offset, &message.payload[kOffset], sizeof request.offset);
    const mav::Address peer = frame.source;
    if (request.size > kDataBytes) {
        refuse(link, peer, request, Error::kDataSize);
        return true;
    }
    Session* session = find(peer, request.session);
    switch (request.opcode) {
        case Opcode::kTerminate:
            if (session != nullptr) *session = {.ticket = ++tickets_};
            [[fallthrough]];
        case Opcode::kNone:
            send(link, peer, request, Opcode::kDone, {});
            return true;
        case Opcode::kReset:
            for (Session& other : sessions_) {
                if (other.peer == peer) other = {.ticket = ++tickets_};
            }
            send(link, peer, request, Opcode::kDone, {});
            return true;
        case Opcode::kList:
        case Opcode::kOpen:
        case Opcode::kCrc:
            if (session == nullptr) session = make(peer, request.session, now_us);
            if (session == nullptr) {
                refuse(link, peer, request, Error::kNoSession);
                return true;
            }
            break;
        case Opcode::kRead:
        case Opcode::kBurst:
            if (session == nullptr || session->file.kind == File::Kind::kNone) {
                refuse(link, peer, request, Error::kSession);
                return true;
            }
            break;
        default: {
            const bool writes =
                request.opcode >= Opcode::kCreateFile && request.opcode <= Opcode::kRename;
            refuse(link, peer, request, writes ? Error::kProtected : Error::kUnknown);
            return true;
        }
    }
    session->line = number;
    session->heard_us = now_us;
    const auto* const text = reinterpret_cast<const char*>(&message.payload[kHeaderBytes]);
    std::string_view path(text, request.size);
    path = path.substr(0, path.find('\0'));
    start(*session, link, request, path);
    return true;
}

FileTransfer::Session* FileTransfer::find(mav::Address peer, uint8_t number) {
    for (Session& session : sessions_) {
        if (session.is_one && session.peer == peer && session.number == number) return &session;
    }
    return nullptr;
}

// A session in which nothing is open, or nothing was heard for long, has to make room.
FileTransfer::Session* FileTransfer::make(mav::Address peer, uint8_t number, uint64_t now_us) {
    for (Session& session : sessions_) {
        const bool is_free =
            !session.is_one || is_idle(session) || now_us - session.heard_us >= kIdle_us;
        if (!is_free) continue;
        session = {.is_one = true, .peer = peer, .number = number, .ticket = ++tickets_};
        return &session;
    }
    return nullptr;
}

// A request that is repeated while its answer is on the way is one; a new one replaces it.
void FileTransfer::start(Session& session, Link& link, const Head& request, std::string_view path) {
    const bool is_repeated =
        session.request.opcode == request.opcode && session.request.sequence == request.sequence;
    if (is_repeated) return;
    const mav::Address to = session.peer;
    switch (request.opcode) {
        case Opcode::kBurst:
            session.burst = request;
            if (request.size == 0) session.burst.size = kDataBytes;
            session.pieces_left = kBurstPieces;
            if (request.offset >= session.bytes) {
                session.pieces_left = 0;
                refuse(link, to, request, Error::kEnd);
            }
            if (session.request.opcode == Opcode::kNone) session.ticket = ++tickets_;
            return;
        case Opcode::kRead:
            if (request.size == 0) return refuse(link, to, request, Error::kDataSize);
            if (request.offset >= session.bytes) return refuse(link, to, request, Error::kEnd);
            break;
        case Opcode::kList:
            session.folder = find_folder(path);
            if (session.folder == Folder::kNone) return refuse(link, to, request, Error::kAbsent);
            break;
        default:
            session.wanted = find_file(path);
            if (session.wanted.kind == File::Kind::kNone) {
                return refuse(link, to, request, Error::kAbsent);
            }
            session.crc = 0;
            break;
    }
    session.request = request;
    session.ticket = ++tickets_;
    if (request.opcode == Opcode::kCrc) session.request.offset = 0;
    if (request.opcode != Opcode::kOpen) return;
    session.file = {};
    session.pieces_left = 0;
}

bool FileTransfer::wants(Session& session, Link& link, FileSource::Wish& wish) {
    const Head& request = session.request;
    is_burst_ = request.opcode == Opcode::kNone;
    ticket_ = session.ticket;
    const auto piece_of_file = [&](const Head& of) {
        const uint32_t left = session.bytes - of.offset;
        wish = {session.file, of.offset, static_cast<uint8_t>(std::min<uint32_t>(of.size, left))};
        return true;
    };
    switch (request.opcode) {
        case Opcode::kNone:
            return session.pieces_left != 0 && piece_of_file(session.burst);
        case Opcode::kList:
            return wants_entry(session, link, wish);
        case Opcode::kRead:
            return piece_of_file(request);
        case Opcode::kCrc:
            wish = {session.wanted, request.offset, kDataBytes};
            return true;
        default:
            wish = {session.wanted};
            return true;
    }
}

// One entry in each answer. Of a file the size is asked for first.
bool FileTransfer::wants_entry(Session& session, Link& link, FileSource::Wish& wish) {
    const Entry entry = entry_of(session.folder, session.request.offset);
    if (entry.name.empty()) {
        refuse(link, session.peer, session.request, Error::kEnd);
    } else if (entry.file.kind == File::Kind::kNone) {
        tell_entry(link, session, session.request, {'D', entry.name});
    } else {
        wish = {entry.file};
        return true;
    }
    end(session);
    return false;
}

void FileTransfer::answer(Session& session, Link& link, const FilePiece& piece) {
    if (is_burst_) return go_on(session, link, piece);
    answer_request(session, link, piece);
}

void FileTransfer::answer_request(Session& session, Link& link, const FilePiece& piece) {
    using Result = FilePiece::Result;
    const Head request = session.request;
    const bool is_there = piece.result == Result::kRead;
    if (request.opcode == Opcode::kCrc && is_there) {
        session.crc = ~crc32(~session.crc, piece.data.data(), piece.length);  // without inversions
        session.request.offset += piece.length;
        if (piece.length == kDataBytes) return;  // it goes on
        end(session);
        return tell(link, session, request, bytes_of(session.crc));
    }
    end(session);
    if (request.opcode == Opcode::kList) {
        if (!is_there) return refuse(link, session.peer, request, Error::kEnd);
        const std::string_view name = entry_of(session.folder, request.offset).name;
        return tell_entry(link, session, request, {'F', name, piece.bytes});
    }
    if (!is_there) {
        const bool is_absent = piece.result == Result::kAbsent;
        return refuse(link, session.peer, request, is_absent ? Error::kAbsent : Error::kFailed);
    }
    if (request.opcode == Opcode::kOpen) {
        session.file = session.wanted;
        session.bytes = piece.bytes;
        session.version = piece.version;
        return tell(link, session, request, bytes_of(piece.bytes));
    }
    if (piece.version != session.version || piece.length == 0) {
        return refuse(link, session.peer, request, Error::kFailed);
    }
    tell(link, session, request, std::span(piece.data).first(piece.length));
}

void FileTransfer::go_on(Session& session, Link& link, const FilePiece& piece) {
    const bool is_read = piece.result == FilePiece::Result::kRead && piece.length != 0 &&
                         piece.version == session.version;
    if (!is_read) {
        session.pieces_left = 0;
        return refuse(link, session.peer, session.burst, Error::kFailed);
    }
    --session.pieces_left;
    const uint32_t next = session.burst.offset + piece.length;
    if (next >= session.bytes) session.pieces_left = 0;
    tell(link, session, session.burst, std::span(piece.data).first(piece.length),
         session.pieces_left == 0);
    session.burst.offset = next;
    ++session.burst.sequence;
}

void FileTransfer::tell_entry(Link& link, const Session& session, const Head& request,
                              const Listed& listed) {
    std::array<uint8_t, kDataBytes> text{};
    uint8_t* at = text.data();
    *at++ = static_cast<uint8_t>(listed.kind);
    at = std::ranges::copy(listed.name, at).out;
    if (listed.kind == 'F') {
        *at++ = '\t';
        at = put_number(at, listed.bytes);
    }
    ++at;  // a zero ends it
    tell(link, session, request, std::span(text.data(), at));
}

void FileTransfer::tell(Link& link, const Session& session, const Head& request,
                        std::span<const uint8_t> data, bool is_last_of_burst) {
    send(link, session.peer, request, Opcode::kDone, data, is_last_of_burst);
}

void FileTransfer::refuse(Link& link, mav::Address to, const Head& request, Error error) {
    const std::array data{static_cast<uint8_t>(error)};
    send(link, to, request, Opcode::kRefused, data);
}

void FileTransfer::send(Link& link, mav::Address to, const Head& request, Opcode opcode,
                        std::span<const uint8_t> data, bool is_last_of_burst) {
    mav::FileTransferProtocol message{.target_system = to.system, .target_component = to.component};
    const auto sequence = static_cast<uint16_t>(request.sequence + 1);
    std::memcpy(message.payload.data(), &sequence, sizeof sequence);
    message.payload[kSession] = request.session;
    message.payload[kOpcode] = static_cast<uint8_t>(opcode);
    message.payload[kSize] = static_cast<uint8_t>(data.size());
    message.payload[kAnswers] = static_cast<uint8_t>(request.opcode);
    message.payload[kLastOfBurst] = is_last_of_burst ? 1 : 0;
    std::memcpy(&message.payload[kOffset], &request.offset, sizeof request.offset);
    std::ranges::copy(data, &message.payload[kHeaderBytes]);
    link.send(message);
}

}  // namespace stator::apps::mavlink
