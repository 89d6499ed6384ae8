// A skin of four MPR121 converters (48 electrodes), over USB serial at 1 Mbaud. Beside this file put
// skinfield_packet.h from the folder skinfield/wire/packet of the installed package.
#include <Wire.h>
#include "skinfield_packet.h"
const int BOARDS = 4, ADDRESS = 0x5A, CHANNELS = 12 * BOARDS;
skinfield_sender sender = {1}; skinfield_ear ear = {};  // device 1
uint8_t packet[SKINFIELD_ROOM(2 * CHANNELS)];
uint16_t counts[CHANNELS]; uint32_t period_us = 10000, last_us = 0;
bool sending = true;

void select_register(int board, uint8_t number) {
  Wire.beginTransmission(ADDRESS + board);
  Wire.write(number);
}
void hello() {
  Serial.write(packet, skinfield_pack_hello(&sender, packet, CHANNELS, SKINFIELD_SHORTS, 0, period_us, "mpr121"));
}
void obey(uint8_t heard) {
  skinfield_header head; uint32_t argument;
  uint8_t command = skinfield_hear(&ear, &sender, heard, &head, &argument);
  if (command == SKINFIELD_START || command == SKINFIELD_STOP) sending = command == SKINFIELD_START;
  if (command == SKINFIELD_PERIOD) period_us = argument;
  if (command == SKINFIELD_ASK) hello();
}
void setup() {
  Serial.begin(1000000); Wire.begin(); Wire.setClock(400000);
  for (int b = 0; b < BOARDS; b++) { select_register(b, 0x5E); Wire.write(0x8C); Wire.endTransmission(); }  // 12 on
  hello();
}
void loop() {
  while (Serial.available()) obey(Serial.read());
  if (!sending || micros() - last_us < period_us) return;
  last_us = micros();
  for (int b = 0; b < BOARDS; b++) {
    select_register(b, 0x04); Wire.endTransmission(false); Wire.requestFrom(ADDRESS + b, 24);
    for (int i = 12 * b; i < 12 * b + 12; i++) { counts[i] = Wire.read(); counts[i] |= Wire.read() << 8; }
  }
  skinfield_begin_reading(&sender, micros());
  Serial.write(packet, skinfield_pack(&sender, packet, SKINFIELD_SHORTS, 0, CHANNELS, counts, 1));
}
