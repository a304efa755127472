// Drivers of simulated devices and of host storage.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "baro_sim.hpp"
#include "battery_sim.hpp"
#include "gnss_sim.hpp"
#include "imu_sim.hpp"
#include "mag_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "radio_sim.hpp"
#include "stator/testing.hpp"
#include "storage_file.hpp"

namespace stator {
namespace {

using drivers::baro::BaroPorts;
using drivers::baro::sim::BaroSim;
using drivers::baro::sim::BaroSimSample;
using drivers::battery::BatteryPorts;
using drivers::battery::sim::BatterySim;
using drivers::gnss::GnssPorts;
using drivers::gnss::sim::GnssSim;
using drivers::imu::ImuPorts;
using drivers::imu::sim::ImuSim;
using drivers::mag::MagPorts;
using drivers::mag::sim::MagSim;
using drivers::mocap::MocapPorts;
using drivers::mocap::sim::MocapSim;
using drivers::motor::MotorPorts;
using drivers::motor::sim::MotorSim;
using drivers::radio::RadioPorts;
using drivers::radio::sim::RadioSim;
using drivers::storage::StoragePorts;
using drivers::storage::file::StorageFile;
using testing::Probe;

TEST(ImuSim, publishes_the_sample_of_its_device) {
    ImuSim::Device device{
        .timestamp_sample = 900, .gyro_B = {1.0F, 2.0F, 3.0F}, .accel_B = {4.0F, 5.0F, 6.0F}};
    ImuSim driver(device);
    ImuPorts ports{.now = 1000};
    ports.fired.data_ready = true;
    Probe accel(ports.accel, ports.now);
    Probe gyro(ports.gyro, ports.now);
    driver.step(ports);
    EXPECT_EQ(accel.newest().timestamp, 1000U);
    EXPECT_EQ(accel.newest().timestamp_sample, 900U);
    EXPECT_EQ(accel.newest().xyz, device.accel_B);
    EXPECT_EQ(gyro.newest().timestamp_sample, 900U);
    EXPECT_EQ(gyro.newest().xyz, device.gyro_B);
}

TEST(ImuSim, publishes_nothing_without_its_line) {
    ImuSim::Device device;
    ImuSim driver(device);
    ImuPorts ports{.now = 1000};
    Probe accel(ports.accel, ports.now);
    Probe gyro(ports.gyro, ports.now);
    driver.step(ports);
    EXPECT_EQ(accel.count() + gyro.count(), 0U);
}

TEST(MocapSim, publishes_heading_as_a_level_attitude) {
    MocapSim::Device device{
        .timestamp_sample = 5000, .position_N = {1.0F, -2.0F, 3.0F}, .yaw = -2.0F};
    MocapSim driver(device);
    MocapPorts ports{.now = 10000};
    ports.fired.received = true;
    Probe odometry(ports.odometry, ports.now);
    driver.step(ports);
    EXPECT_EQ(odometry.newest().timestamp_sample, 5000U);
    EXPECT_EQ(odometry.newest().position, device.position_N);
    // cos(-1), sin(-1) from a table.
    EXPECT_NEAR(odometry.newest().q[0], 0.540302F, 1e-6F);
    EXPECT_EQ(odometry.newest().q[1], 0.0F);
    EXPECT_EQ(odometry.newest().q[2], 0.0F);
    EXPECT_NEAR(odometry.newest().q[3], -0.841471F, 1e-6F);
}

TEST(MocapSim, publishes_nothing_without_its_line) {
    MocapSim::Device device;
    MocapSim driver(device);
    MocapPorts ports{.now = 10000};
    Probe odometry(ports.odometry, ports.now);
    driver.step(ports);
    EXPECT_EQ(odometry.count(), 0U);
}

TEST(MagSim, publishes_the_sample_of_its_device) {
    MagSim::Device device{.timestamp_sample = 900, .field_B_gauss = {0.2F, -0.1F, 0.4F}};
    MagSim driver(device);
    MagPorts ports{.now = 1000};
    Probe mag(ports.mag, ports.now);
    driver.step(ports);
    EXPECT_EQ(mag.count(), 0U);  // without its line
    ports.fired.data_ready = true;
    driver.step(ports);
    EXPECT_EQ(mag.newest().timestamp_sample, 900U);
    EXPECT_EQ(mag.newest().xyz, device.field_B_gauss);
}

TEST(BaroSim, publishes_each_sample_once) {
    const BaroSimSample sample{
        .timestamp_sample = 900, .pressure = 95600.0F, .temperature_degc = 27.0F};
    BaroSim::Device device;
    device.put(sample);
    BaroSim driver(device);
    BaroPorts ports{.now = 1000};
    Probe pressure(ports.pressure, ports.now);
    driver.step(ports);
    EXPECT_EQ(pressure.newest().timestamp_sample, 900U);
    EXPECT_EQ(pressure.newest().pressure, 95600.0F);
    EXPECT_EQ(pressure.newest().temperature, 27.0F);
    driver.step(ports);
    EXPECT_EQ(pressure.count(), 1U);
    device.put(sample);
    driver.step(ports);
    EXPECT_EQ(pressure.count(), 2U);
}

TEST(GnssSim, publishes_the_fix_with_its_own_time) {
    GnssSim::Device device{.timestamp_sample = 200000,
                           .latitude_deg = 47.4,
                           .longitude_deg = 8.5,
                           .altitude_msl_m = 488.0,
                           .altitude_ellipsoid_m = 535.6,
                           .velocity_N = {1.0F, 2.0F, 3.0F},
                           .horizontal_error = 1.7F,
                           .vertical_error = 2.4F,
                           .speed_error = 0.3F,
                           .satellites = 4};
    GnssSim driver(device);
    GnssPorts ports{.now = 310000};
    Probe position(ports.position, ports.now);
    driver.step(ports);
    EXPECT_EQ(position.count(), 0U);  // without its line
    ports.fired.received = true;
    driver.step(ports);
    EXPECT_EQ(position.newest().timestamp, 310000U);
    EXPECT_EQ(position.newest().timestamp_sample, 200000U);
    EXPECT_EQ(position.newest().latitude_deg, 47.4);
    EXPECT_EQ(position.newest().longitude_deg, 8.5);
    EXPECT_EQ(position.newest().altitude_msl_m, 488.0);
    EXPECT_EQ(position.newest().altitude_ellipsoid_m, 535.6);
    EXPECT_EQ(position.newest().vel_d_m_s, 3.0F);
    EXPECT_EQ(position.newest().eph, 1.7F);
    EXPECT_EQ(position.newest().epv, 2.4F);
    EXPECT_EQ(position.newest().s_variance_m_s, 0.3F);
    EXPECT_EQ(position.newest().fix_type, SensorGps::FixType::kFix3d);
    EXPECT_TRUE(position.newest().vel_ned_valid);
    EXPECT_EQ(position.newest().satellites_used, 4);
}

TEST(GnssSim, has_no_fix_with_three_satellites) {
    GnssSim::Device device{.satellites = 3};
    GnssSim driver(device);
    GnssPorts ports{.now = 310000};
    ports.fired.received = true;
    Probe position(ports.position, ports.now);
    driver.step(ports);
    EXPECT_EQ(position.newest().fix_type, SensorGps::FixType::kNone);
    EXPECT_FALSE(position.newest().vel_ned_valid);
}

BatteryStatus battery_status(float remaining, float voltage_v = 11.0F) {
    BatterySim::Device device;
    device.put({.voltage_v = voltage_v,
                .current_a = 14.0F,
                .discharged_mah = 100.0F,
                .remaining = remaining});
    BatterySim driver(device);
    const BatteryParams params{.timestamp = 0, .low = 0.15F, .critical = 0.07F, .emergency = 0.05F};
    BatteryPorts ports{.now = 1000, .params = Input(params)};
    Probe status(ports.status, ports.now);
    driver.step(ports);
    return status.newest();
}

TEST(BatterySim, publishes_what_its_device_says) {
    const BatteryStatus status = battery_status(0.8F);
    EXPECT_TRUE(status.connected);
    EXPECT_EQ(status.voltage_v, 11.0F);
    EXPECT_EQ(status.current_a, 14.0F);
    EXPECT_EQ(status.discharged_mah, 100.0F);
    EXPECT_EQ(status.remaining, 0.8F);
}

TEST(BatterySim, warns_below_each_threshold) {
    using Warning = BatteryStatus::Warning;
    EXPECT_EQ(battery_status(0.15F).warning, Warning::kNone);
    EXPECT_EQ(battery_status(0.14F).warning, Warning::kLow);
    EXPECT_EQ(battery_status(0.06F).warning, Warning::kCritical);
    EXPECT_EQ(battery_status(0.04F).warning, Warning::kEmergency);
    EXPECT_FALSE(battery_status(0.04F, 0.0F).connected);
    EXPECT_EQ(battery_status(0.04F, 0.0F).warning, Warning::kNone);
}

TEST(RadioSim, publishes_switches_and_sticks_of_a_frame) {
    RadioSim::Device device{.timestamp_sample = 900,
                            .roll = 0.1F,
                            .pitch = 0.2F,
                            .yaw = 0.3F,
                            .throttle = 0.4F,
                            .mode_slot = 5,
                            .is_heard = true,
                            .arm = true};
    RadioSim driver(device);
    RadioPorts ports{.now = 1000};
    ports.fired.received = true;
    Probe switches(ports.switches, ports.now);
    Probe sticks(ports.sticks, ports.now);
    driver.step(ports);
    EXPECT_EQ(sticks.newest().timestamp_sample, 900U);
    EXPECT_TRUE(sticks.newest().valid);
    EXPECT_EQ(sticks.newest().roll, 0.1F);
    EXPECT_EQ(sticks.newest().pitch, 0.2F);
    EXPECT_EQ(sticks.newest().yaw, 0.3F);
    EXPECT_EQ(sticks.newest().throttle, 0.4F);
    EXPECT_EQ(switches.newest().mode_slot, 5);
    EXPECT_EQ(switches.newest().arm_switch, ManualControlSwitches::ArmSwitch::kOn);
    EXPECT_EQ(switches.newest().return_switch, ManualControlSwitches::ReturnSwitch::kOff);
    EXPECT_EQ(switches.newest().kill_switch, ManualControlSwitches::KillSwitch::kOff);
    device = {.is_heard = false, .return_home = true, .kill = true};
    driver.step(ports);
    EXPECT_FALSE(sticks.newest().valid);
    EXPECT_EQ(switches.newest().return_switch, ManualControlSwitches::ReturnSwitch::kOn);
    EXPECT_EQ(switches.newest().kill_switch, ManualControlSwitches::KillSwitch::kOn);
    ports.fired.received = false;
    driver.step(ports);
    EXPECT_EQ(sticks.count(), 2U);
}

int writes = 0;
MotorSim::Control written{};
void keep(const MotorSim::Control& control) {
    ++writes;
    written = control;
}

TEST(MotorSim, hands_each_command_over) {
    MotorSim::Device device{.write = keep};
    MotorSim driver(device);
    ActuatorMotors command{};
    command.control.fill(std::numeric_limits<float>::quiet_NaN());
    command.control[2] = 0.25F;
    MotorPorts ports{.now = 1000, .command = Input(command)};
    writes = 0;
    driver.step(ports);
    EXPECT_EQ(writes, 1);
    EXPECT_EQ(written[2], 0.25F);
    EXPECT_NE(written[3], written[3]);  // not a number
}

TEST(MotorSim, stops_motors_that_nothing_commands_any_more) {
    MotorSim::Device device{.write = keep};
    MotorSim driver(device);
    ActuatorMotors command{};
    command.control.fill(0.25F);
    MotorPorts ports{.now = 1000, .command = Input(command)};
    driver.step(ports);
    writes = 0;
    MotorPorts soon{.now = 1'301'000};
    driver.step(soon);
    EXPECT_EQ(writes, 0);
    MotorPorts late{.now = 1'301'001};
    driver.step(late);
    EXPECT_EQ(writes, 1);
    EXPECT_NE(written[0], written[0]);  // not a number
}

TEST(MotorSim, does_nothing_without_command_or_board) {
    MotorSim::Device connected{.write = keep};
    MotorPorts empty{.now = 1000};
    writes = 0;
    MotorSim(connected).step(empty);
    EXPECT_EQ(writes, 0);
    MotorSim::Device unconnected;
    const ActuatorMotors command{};
    MotorPorts ports{.now = 1000, .command = Input(command)};
    MotorSim(unconnected).step(ports);
}

LogBlock block_of(const char* text) {
    LogBlock block{};
    block.length = static_cast<uint32_t>(std::strlen(text));
    std::memcpy(block.data.data(), text, block.length);
    return block;
}

void store(StorageFile& driver, const LogBlock& block) {
    StoragePorts ports{.now = 1000, .block = Input(block)};
    driver.step(ports);
}

TEST(StorageFile, appends_blocks_in_order) {
    StorageFile::Device device{.file = std::tmpfile()};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    store(driver, block_of("flight"));
    store(driver, block_of(""));
    store(driver, block_of(" log"));
    std::rewind(device.file);
    std::array<char, 32> text{};
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), device.file), 10U);
    EXPECT_STREQ(text.data(), "flight log");
    EXPECT_EQ(device.bytes_written, 10U);
    EXPECT_EQ(device.errors, 0U);
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, writes_no_more_than_a_block_holds) {
    StorageFile::Device device{.file = std::tmpfile()};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    LogBlock block{};
    block.length = 0xffffffff;
    store(driver, block);
    EXPECT_EQ(device.bytes_written, block.data.size());
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, counts_what_it_could_not_write) {
    StorageFile::Device device{.file = std::fopen("/dev/null", "rb")};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    store(driver, block_of("lost"));
    EXPECT_EQ(device.errors, 1U);
    EXPECT_EQ(device.bytes_written, 0U);
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, drops_blocks_without_a_file) {
    StorageFile::Device device;
    StorageFile driver(device);
    store(driver, block_of("lost"));
    EXPECT_EQ(device.bytes_written + device.errors, 0U);
}

}  // namespace
}  // namespace stator
