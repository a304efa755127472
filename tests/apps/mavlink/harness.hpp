// A vehicle with two lines, for tests of the node: ground stations write bytes and read messages.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "mavlink.hpp"
#include "stator/testing.hpp"

namespace stator::apps::mavlink {

using Nav = VehicleStatus::NavState;

// Everything that an output publishes in one activation.
template <class Message>
class Everything {
  public:
    Everything(Output<Message>& output, uint64_t now_us, uint16_t burst) {
        output.connect(topic_, now_us, true, burst);
    }
    std::vector<Message> all() {
        Input<Message> input;
        uint32_t cursor = 0;
        input.open_queue(topic_, cursor, 0);
        std::vector<Message> messages;
        while (input.next()) messages.push_back(*input);
        return messages;
    }

  private:
    TopicState state_{Shared<uint32_t>(all_slots(16)), {}, {}};
    std::array<Message, 16> samples_{};
    std::array<Shared<uint32_t>, 16> number_{};
    std::array<Shared<uint32_t>, 16> ring_{};
    Topic topic_{.state = &state_,
                 .samples = samples_.data(),
                 .number = number_.data(),
                 .ring = ring_.data(),
                 .subscribers = nullptr,
                 .thinned = nullptr,
                 .in_section = nullptr,
                 .sample_bytes = sizeof(Message),
                 .subscriber_count = 0,
                 .thinned_count = 0,
                 .slots = 16,
                 .depth = 8,
                 .ceiling = 0};
};

// A message that a ground station received.
struct Heard {
    uint32_t id;
    std::vector<uint8_t> payload;
    uint64_t time_us;
    mav::Address from;
    std::vector<uint8_t> frame;

    template <class Message>
    Message as() const {
        return mav::decode<Message>(payload);
    }
};

class MavlinkTest : public ::testing::Test {
  protected:
    static constexpr mav::Address kGround{255, 190};
    static constexpr uint64_t kPeriod_us = 10'000;

    struct Station {
        std::deque<uint8_t> out;
        mav::Parser parser{mav::kKnown};
        std::vector<Heard> heard;
        uint8_t sequence = 0;
        unsigned datagram_bytes = 0;
        std::size_t received_bytes = 0;
    };

    MavlinkTest() {
        line_.bytes_per_s = 48'000;
        status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
        status_.nav_state = Nav::kHold;
        position_.xy_valid = position_.z_valid = position_.xy_global = position_.z_global = true;
        position_.ref_lat = 47.4;
        position_.ref_lon = 8.5;
        position_.ref_alt = 500.0F;
        position_.x = 1.0F;
        position_.y = 2.0F;
        position_.z = -3.0F;
        attitude_.q = {1.0F, 0.0F, 0.0F, 0.0F};
    }

    template <class Message>
    void send(const Message& message, unsigned line = 0, mav::Address from = kGround) {
        mav::FrameBytes frame;
        frame.put(message, stations_[line].sequence++, from);
        send_bytes(frame.bytes(), line);
    }
    void send_bytes(std::span<const uint8_t> bytes, unsigned line = 0) {
        stations_[line].out.insert(stations_[line].out.end(), bytes.begin(), bytes.end());
    }
    void send_command(uint16_t command, std::array<float, 7> p, unsigned line = 0,
                      mav::Address from = kGround) {
        send(mav::CommandLong{.param1 = p[0],
                              .param2 = p[1],
                              .param3 = p[2],
                              .param4 = p[3],
                              .param5 = p[4],
                              .param6 = p[5],
                              .param7 = p[6],
                              .command = command,
                              .target_system = 1,
                              .target_component = 1},
             line, from);
    }

    std::optional<SerialBytes> next_piece(Station& station) {
        if (station.out.empty()) return {};
        SerialBytes piece{};
        while (!station.out.empty() && piece.length < piece.data.size()) {
            piece.data[piece.length++] = station.out.front();
            station.out.pop_front();
        }
        return piece;
    }
    void hear(Station& station, const std::vector<SerialBytes>& pieces) {
        for (const SerialBytes& piece : pieces) {
            if (piece.adopts) {
                adopted_[&station == &stations_[1] ? 1 : 0].push_back(piece);
                continue;
            }
            std::span<const uint8_t> bytes = std::span(piece.data).first(piece.length);
            station.received_bytes += bytes.size();
            while (const auto frame = station.parser.next(bytes, now_us_)) {
                station.heard.push_back({frame->id,
                                         {frame->payload.begin(), frame->payload.end()},
                                         now_us_,
                                         frame->source,
                                         {frame->bytes.begin(), frame->bytes.end()}});
            }
            if (!piece.ends) continue;
            // A datagram holds whole frames.
            EXPECT_EQ(station.parser.counters().skipped, 0U);
        }
    }

    void step() {
        now_us_ += kPeriod_us;
        const std::array pieces{next_piece(stations_[0]), next_piece(stations_[1])};
        const auto received = [&](unsigned i) {
            return pieces.at(i) ? Input(*pieces.at(i)) : Input<SerialBytes>();
        };
        MavlinkPorts ports{.now = now_us_,
                           .received1 = received(0),
                           .line1 = is_open_[0] ? Input(line_) : Input<SerialStatus>(),
                           .received2 = received(1),
                           .line2 = is_open_[1] ? Input(line_) : Input<SerialStatus>(),
                           .status = Input(status_),
                           .health = Input(health_),
                           .home = Input(home_),
                           .position = Input(position_),
                           .attitude = Input(attitude_),
                           .land = Input(land_),
                           .gyro = Input(gyro_),
                           .accel = Input(accel_),
                           .mag = Input(mag_),
                           .baro = Input(baro_),
                           .gnss = Input(gnss_),
                           .battery = Input(battery_),
                           .sticks = Input(sticks_),
                           .fence = Input(fence_),
                           .mission = Input(mission_, is_mission_new_),
                           .result = Input(result_),
                           .ack = ack_ ? Input(*ack_) : Input<VehicleCommandAck>(),
                           .downloaded = item_ ? Input(*item_) : Input<MissionItem>(),
                           .parameter = parameter_ ? Input(*parameter_) : Input<ParameterValue>(),
                           .parameter_file = piece_ ? Input(*piece_) : Input<FilePiece>(),
                           .goal = Input(goal_),
                           .switches = Input(switches_),
                           .radio = has_radio_ ? Input(radio_) : Input<ManualControlSetpoint>(),
                           .printed = printed_ ? Input(*printed_) : Input<ShellText>(),
                           .notice = notice_ ? Input(*notice_) : Input<StatusText>(),
                           .stored = stored_ ? Input(*stored_) : Input<StoredRecord>(),
                           .calibrating = Input(calibrating_),
                           .params = Input(params_, is_first_),
                           .metadata = &metadata_};
        Everything<SerialBytes> first(ports.send1, now_us_, Link::kPieces);
        Everything<SerialBytes> second(ports.send2, now_us_, Link::kPieces);
        Everything<VehicleCommand> commands(ports.command, now_us_, 1);
        Everything<MissionUpload> uploads(ports.upload, now_us_, 4);
        Everything<MissionRequest> downloads(ports.download, now_us_, 1);
        Everything<ParameterRequest> questions(ports.parameter_request, now_us_, 2);
        Everything<ManualControlSetpoint> station_sticks(ports.station_sticks, now_us_, 1);
        Everything<OffboardSetpoint> setpoints(ports.offboard, now_us_, 1);
        Everything<StationHeartbeat> beats(ports.station, now_us_, 1);
        Everything<RestartRequest> restarts(ports.restart, now_us_, 1);
        Everything<FileRequest> wanted_pieces(ports.file_request, now_us_, 1);
        Everything<ShellText> typed(ports.typed, now_us_, 5);
        Everything<CalibrationRequest> calibrations(ports.calibration, now_us_, 1);
        Everything<StoredRecord> to_store(ports.store, now_us_, 1);
        node_.step(ports);
        EXPECT_EQ(ports.store.refused(), 0);
        for (const StoredRecord& record : to_store.all()) kept_.push_back(record);
        stored_.reset();
        notice_.reset();
        EXPECT_EQ(ports.calibration.refused(), 0);
        for (const auto& sample : calibrations.all()) calibrations_.push_back(sample);
        EXPECT_EQ(ports.typed.refused(), 0);
        printed_.reset();
        for (const ShellText& text : typed.all()) take(text);
        EXPECT_EQ(ports.restart.refused(), 0);
        restarts_ += restarts.all().size();
        EXPECT_EQ(ports.station_sticks.refused() + ports.offboard.refused(), 0);
        for (const auto& sample : station_sticks.all()) station_sticks_.push_back(sample);
        for (const auto& sample : setpoints.all()) setpoints_.push_back(sample);
        for (const auto& sample : beats.all()) beats_.push_back(sample);
        is_first_ = false;
        ack_.reset();
        item_.reset();
        parameter_.reset();
        piece_.reset();
        is_mission_new_ = false;
        EXPECT_EQ(ports.upload.refused() + ports.download.refused(), 0);
        EXPECT_EQ(ports.send1.refused() + ports.send2.refused() + ports.command.refused(), 0);
        hear(stations_[0], first.all());
        hear(stations_[1], second.all());
        EXPECT_EQ(ports.parameter_request.refused(), 0);
        for (const ParameterRequest& question : questions.all()) answer(question);
        EXPECT_EQ(ports.file_request.refused(), 0);
        for (const FileRequest& wanted : wanted_pieces.all()) answer(wanted);
        keep(uploads.all());
        for (const MissionRequest& wanted : downloads.all()) answer(wanted);
        for (const VehicleCommand& command : commands.all()) {
            commands_.push_back(command);
            if (answers_)
                ack_ = VehicleCommandAck{.tag = command.tag, .result = result_of_commands_};
        }
    }
    // As the mission device does, at once.
    void keep(const std::vector<MissionUpload>& parts) {
        for (const MissionUpload& part : parts) {
            const auto list = static_cast<unsigned>(part.list);
            if (part.action == MissionUpload::Action::kBegin) {
                new_items_.clear();
                expected_ = part.count;
            } else if (part.action == MissionUpload::Action::kItems) {
                EXPECT_EQ(part.first, new_items_.size());
                new_items_.push_back({.index = part.first,
                                      .list = static_cast<MissionItem::List>(part.list),
                                      .frame = part.frame[0],
                                      .command = part.command[0],
                                      .autocontinue = part.autocontinue[0],
                                      .param1 = part.param1[0],
                                      .param2 = part.param2[0],
                                      .param3 = part.param3[0],
                                      .param4 = part.param4[0],
                                      .x = part.x[0],
                                      .y = part.y[0],
                                      .z = part.z[0]});
            } else {
                is_mission_new_ = true;
                if (new_items_.size() != expected_ || device_is_broken_) {
                    ++mission_.refused;
                    continue;
                }
                lists_[list] = new_items_;
                const uint32_t id = lists_[list].empty() ? 0 : ++ids_;
                const auto count = static_cast<uint16_t>(lists_[list].size());
                if (list == 0) mission_.mission_id = id, mission_.count = count;
                if (list == 1) mission_.geofence_id = id, mission_.geofence_count = count;
                if (list == 2) mission_.safe_points_id = id, mission_.safe_points_count = count;
            }
        }
    }
    // As the node with all parameters does.
    void answer(const ParameterRequest& question) {
        ++questions_;
        if (!knows_parameters_) return;
        std::string name;
        for (const uint8_t c : question.name) {
            if (c != 0) name += static_cast<char>(c);
        }
        const auto found = name.empty() ? parameters_.begin() + question.index
                                        : std::ranges::find(parameters_, name, &Parameter::id);
        using Result = ParameterValue::Result;
        ParameterValue value{
            .requester = static_cast<ParameterValue::Requester>(question.requester),
            .tag = question.tag,
            .result = Result::kUnknown,
            .count = static_cast<uint16_t>(parameters_.size())};
        if (found < parameters_.end()) {
            Parameter& parameter = *found;
            value.result = Result::kRead;
            value.type = parameter.type;
            value.index = static_cast<uint16_t>(found - parameters_.begin());
            const bool sets = question.action == ParameterRequest::Action::kSet;
            const bool is_same =
                static_cast<int>(question.type) == static_cast<int>(parameter.type);
            if (sets) value.result = is_same ? Result::kWritten : Result::kWrongType;
            if (sets && is_same) {
                parameter.real = question.float_value;
                parameter.whole = question.int_value;
            }
            value.float_value = parameter.real;
            value.int_value = parameter.whole;
            for (std::size_t i = 0; i < parameter.id.size(); ++i) {
                value.id[i] = static_cast<uint8_t>(parameter.id[i]);
            }
        }
        parameter_ = value;
    }

    // As the nodes with files do.
    void answer(const FileRequest& wanted) {
        ++pieces_;
        const bool is_log = wanted.file == FileRequest::File::kLog;
        if (is_log && !reads_logs_) return;
        FilePiece piece{.tag = wanted.tag, .result = FilePiece::Result::kAbsent};
        if (is_log) piece.logs = static_cast<uint16_t>(logs_.size());
        if (!is_log || wanted.log < logs_.size()) {
            const std::vector<uint8_t>& file = is_log ? logs_[wanted.log] : pack_;
            piece.result = FilePiece::Result::kRead;
            piece.bytes = static_cast<uint32_t>(file.size());
            piece.version = version_;
            for (std::size_t i = wanted.offset; i < file.size() && piece.length < wanted.length;
                 ++i) {
                piece.data[piece.length++] = file[i];
            }
        }
        piece_ = piece;
    }

    // A shell that prints what was typed.
    void take(const ShellText& text) {
        std::string& typed = shell_.at(text.console);
        if (text.is_new) typed.clear();
        if (text.is_new) ++new_consoles_;
        typed.append(text.data.begin(), text.data.begin() + text.length);
        if (!text.wants_text) return;
        ++wants_;
        if (!shell_answers_) return;
        ShellText printed{.console = text.console, .tag = text.tag};
        printed.length = static_cast<uint8_t>(std::min<std::size_t>(typed.size(), 70));
        std::copy_n(typed.begin(), printed.length, printed.data.begin());
        typed.erase(0, printed.length);
        printed.has_more = !typed.empty();
        printed_ = printed;
    }

    void answer(const MissionRequest& wanted) {
        const auto list = static_cast<unsigned>(wanted.list);
        ++device_reads_;
        if (wanted.first >= lists_[list].size()) return;
        item_ = lists_[list][wanted.first];
        const std::array ids{mission_.mission_id, mission_.geofence_id, mission_.safe_points_id};
        item_->id = ids.at(list);
    }

    void run(double seconds) {
        const auto steps = static_cast<unsigned>(seconds * 1e6) / kPeriod_us;
        for (unsigned i = 0; i < steps; ++i) step();
    }

    std::vector<Heard> heard(uint32_t id, unsigned line = 0) const {
        std::vector<Heard> found;
        for (const Heard& message : stations_[line].heard) {
            if (message.id == id) found.push_back(message);
        }
        return found;
    }
    template <class Message>
    std::vector<Message> heard(unsigned line = 0) const {
        std::vector<Message> found;
        for (const Heard& message : heard(Message::kId, line)) {
            found.push_back(message.template as<Message>());
        }
        return found;
    }
    void forget() {
        for (Station& station : stations_) station.heard.clear();
    }
    // The results of all answers to a command.
    std::vector<int> results(uint16_t command, unsigned line = 0) const {
        std::vector<int> found;
        for (const auto& ack : heard<mav::CommandAck>(line)) {
            if (ack.command == command) found.push_back(ack.result);
        }
        return found;
    }

    std::array<Station, 2> stations_;
    std::array<bool, 2> is_open_{true, false};
    SerialStatus line_{};
    VehicleStatus status_{};
    HealthReport health_{};
    HomePosition home_{};
    VehicleLocalPosition position_{};
    VehicleAttitude attitude_{};
    VehicleLandDetected land_{};
    SensorGyro gyro_{};
    SensorAccel accel_{};
    SensorMag mag_{};
    SensorBaro baro_{};
    SensorGps gnss_{};
    BatteryStatus battery_{};
    ManualControlSetpoint sticks_{};
    GeofenceResult fence_{};
    Mission mission_{};
    MissionResult result_{.seq_reached = -1};
    MavlinkParams params_{.allows1 = 0xFF, .allows2 = 0xFF};
    GotoSetpoint goal_{};
    ManualControlSwitches switches_{};
    ManualControlSetpoint radio_{};
    bool has_radio_ = false;
    std::array<std::vector<SerialBytes>, 2> adopted_;  // by line
    std::optional<StoredRecord> stored_;
    std::vector<StoredRecord> kept_;
    std::optional<VehicleCommandAck> ack_;
    bool answers_ = true;  // to commands
    VehicleCommandAck::Result result_of_commands_ = VehicleCommandAck::Result::kAccepted;
    std::vector<VehicleCommand> commands_;
    std::vector<ManualControlSetpoint> station_sticks_;
    std::vector<OffboardSetpoint> setpoints_;
    std::vector<StationHeartbeat> beats_;
    std::size_t restarts_ = 0;
    struct Parameter {
        std::string id;
        ParameterValue::Type type;
        float real = 0.0F;
        int32_t whole = 0;
    };
    std::vector<Parameter> parameters_;
    std::optional<ParameterValue> parameter_;
    std::optional<StatusText> notice_;
    CalibrationStatus calibrating_{};
    std::vector<CalibrationRequest> calibrations_;
    std::optional<ShellText> printed_;
    std::array<std::string, 2> shell_;  // what it has yet to print
    unsigned new_consoles_ = 0;
    unsigned wants_ = 0;
    bool shell_answers_ = true;
    unsigned questions_ = 0;
    bool knows_parameters_ = true;
    std::vector<uint8_t> pack_;  // the file of all parameters
    uint32_t version_ = 1;       // of what is in it
    std::vector<std::vector<uint8_t>> logs_;
    bool reads_logs_ = true;
    unsigned pieces_ = 0;  // that were asked for
    std::optional<FilePiece> piece_;
    static constexpr std::array<uint8_t, 4> kGeneral{'g', 'e', 'n', 'e'};
    static constexpr std::array<uint8_t, 500> kDescribed{1, 2, 3};
    const Metadata metadata_{{kGeneral.data(), kGeneral.size(), 0x1234},
                             {kDescribed.data(), kDescribed.size(), 0x5678}};
    std::array<std::vector<MissionItem>, 3> lists_;  // of the mission device
    std::vector<MissionItem> new_items_;
    std::size_t expected_ = 0;
    uint32_t ids_ = 100;
    unsigned device_reads_ = 0;
    bool device_is_broken_ = false;
    bool is_mission_new_ = true;
    std::optional<MissionItem> item_;
    bool is_first_ = true;
    uint64_t now_us_ = 0;
    Mavlink node_;
};

}  // namespace stator::apps::mavlink
