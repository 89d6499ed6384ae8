/* skinfield packets, version 1: counts of a capacitive skin over UDP, TCP or serial.
 *
 * One file, no allocation, no dependencies, C99 and C++. Little-endian machines only, which is what
 * Arduino, ESP32, STM32, RP2040 and PCs are. The layout is in docs/reference/packet.md of skinfield.
 *
 *     static uint8_t packet[SKINFIELD_ROOM(2 * 72)];
 *     static skinfield_sender sender = {1};             // device 1
 *     skinfield_begin_reading(&sender, micros());       // for each reading
 *     size_t n = skinfield_pack(&sender, packet, SKINFIELD_SHORTS, 0, 72, counts, 1);
 *     send(packet, n);
 */
#ifndef SKINFIELD_PACKET_H
#define SKINFIELD_PACKET_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "skinfield_packet.h is for little-endian machines: write the header's numbers byte by byte"
#endif

#define SKINFIELD_VERSION 1
#define SKINFIELD_LONGEST_PAYLOAD 4064 /* bytes */
#define SKINFIELD_EVERY_DEVICE 0xFFFF
#define SKINFIELD_ROOM(payload) (24 + (payload) + 2) /* bytes of a packet */

enum { /* kinds */
  SKINFIELD_BYTES = 1,   /* counts, uint8_t each */
  SKINFIELD_SHORTS = 2,  /* counts, uint16_t each */
  SKINFIELD_FLOATS = 3,  /* numbers, float each; NAN where a taxel did not answer */
  SKINFIELD_STATUS = 4,  /* no counts: the status byte, and a bit per channel: out of range */
  SKINFIELD_SIGNED = 5,  /* counts, int16_t each */
  SKINFIELD_HELLO = 16,  /* what the device is */
  SKINFIELD_ANSWER = 17, /* to a command */
  SKINFIELD_START = 32,  /* from the host: send readings */
  SKINFIELD_STOP = 33,
  SKINFIELD_PERIOD = 34, /* payload uint32_t: microseconds from reading to reading */
  SKINFIELD_TARE = 35,   /* take the baseline anew */
  SKINFIELD_ASK = 36     /* send a HELLO */
};

enum { /* bits of status, of all channels of a packet */
  SKINFIELD_NO_ACK = 1,
  SKINFIELD_NOT_CONNECTED = 2,
  SKINFIELD_OUT_OF_RANGE = 4,
  SKINFIELD_INVALID = 8
};

enum { SKINFIELD_LAST = 1 }; /* flag: the reading is complete with this packet */

#pragma pack(push, 1)
typedef struct {
  uint8_t magic[2]; /* 'S', 'F' */
  uint8_t version;
  uint8_t kind;
  uint16_t device;
  uint16_t length;   /* of the payload, bytes */
  uint32_t sequence; /* 0 after the start, one more with every packet */
  uint32_t time_us;  /* of the device */
  uint16_t channel;  /* the first */
  uint16_t count;    /* of channels */
  uint16_t reading;  /* its number, the same in all its packets */
  uint8_t flags;
  uint8_t status;
} skinfield_header; /* 24 bytes; payload and a CRC-16 follow */

typedef struct {
  uint16_t channels;
  uint8_t kind;       /* of the counts */
  uint8_t unit;       /* 0 count, 1 dC/C0, 2 Pa, 3 indentation over thickness */
  uint32_t period_us; /* 0 if unknown */
  uint8_t layout[8];  /* fingerprint of the layout, zeros if unknown */
  uint8_t name_length;
} skinfield_hello; /* 17 bytes; the name follows, at most 64 bytes of UTF-8 */

typedef struct {
  uint8_t command;
  uint8_t result; /* 0 done, 1 unknown, 2 refused */
  uint16_t zero;
  uint32_t sequence; /* of the command */
} skinfield_answer;
#pragma pack(pop)

typedef struct {
  uint16_t device;
  uint16_t reading;
  uint32_t sequence;
  uint32_t time_us;
  uint8_t status;
} skinfield_sender;

/* CRC-16/CCITT-FALSE: polynomial 0x1021, begins with 0xFFFF; of "123456789" it is 0x29B1. */
static inline uint16_t skinfield_crc(const uint8_t *data, size_t size) {
  uint16_t crc = 0xFFFF;
  size_t i;
  for (i = 0; i < size; i++) { /* a whole byte without a table, so small in flash */
    uint8_t x = (uint8_t)((crc >> 8) ^ data[i]);
    x = (uint8_t)(x ^ (x >> 4));
    crc = (uint16_t)((crc << 8) ^ ((uint16_t)x << 12) ^ ((uint16_t)x << 5) ^ x);
  }
  return crc;
}

/* Bytes of a channel's count; 0 for kinds that have none. */
static inline size_t skinfield_width(uint8_t kind) {
  return kind == SKINFIELD_BYTES                                 ? 1
         : kind == SKINFIELD_SHORTS || kind == SKINFIELD_SIGNED ? 2
         : kind == SKINFIELD_FLOATS                              ? 4
                                                                 : 0;
}

/* Begin a reading: the next packets are of this time. */
static inline void skinfield_begin_reading(skinfield_sender *sender, uint32_t time_us) {
  if (sender->sequence) sender->reading++;
  sender->time_us = time_us;
}

/* Write a packet with any payload; its bytes, or 0 if the payload is too long. */
static inline size_t skinfield_pack_any(skinfield_sender *sender, uint8_t *packet, uint8_t kind,
                                        uint16_t channel, uint16_t count, const void *payload,
                                        size_t length, uint8_t flags) {
  skinfield_header head;
  uint16_t crc;
  if (length > SKINFIELD_LONGEST_PAYLOAD) return 0;
  head.magic[0] = 'S';
  head.magic[1] = 'F';
  head.version = SKINFIELD_VERSION;
  head.kind = kind;
  head.device = sender->device;
  head.length = (uint16_t)length;
  head.sequence = sender->sequence++;
  head.time_us = sender->time_us;
  head.channel = channel;
  head.count = count;
  head.reading = sender->reading;
  head.flags = flags;
  head.status = sender->status;
  memcpy(packet, &head, sizeof head);
  if (length) memcpy(packet + sizeof head, payload, length);
  crc = skinfield_crc(packet, sizeof head + length);
  memcpy(packet + sizeof head + length, &crc, 2);
  return SKINFIELD_ROOM(length);
}

/* Write a packet of counts; `last` where the reading is complete with it. Its bytes, or 0. */
static inline size_t skinfield_pack(skinfield_sender *sender, uint8_t *packet, uint8_t kind,
                                    uint16_t channel, uint16_t count, const void *counts,
                                    int last) {
  return skinfield_pack_any(sender, packet, kind, channel, count, counts,
                            skinfield_width(kind) * count, last ? SKINFIELD_LAST : 0);
}

/* Write a HELLO: the first packet after the start, and the answer to SKINFIELD_ASK. */
static inline size_t skinfield_pack_hello(skinfield_sender *sender, uint8_t *packet,
                                          uint16_t channels, uint8_t kind, uint8_t unit,
                                          uint32_t period_us, const char *name) {
  uint8_t payload[sizeof(skinfield_hello) + 64];
  skinfield_hello hello;
  size_t length = strlen(name) > 64 ? 64 : strlen(name);
  memset(&hello, 0, sizeof hello);
  hello.channels = channels;
  hello.kind = kind;
  hello.unit = unit;
  hello.period_us = period_us;
  hello.name_length = (uint8_t)length;
  memcpy(payload, &hello, sizeof hello);
  memcpy(payload + sizeof hello, name, length);
  return skinfield_pack_any(sender, packet, SKINFIELD_HELLO, 0, 0, payload, sizeof hello + length,
                            SKINFIELD_LAST);
}

/* Look for a packet at the beginning of `data`: its bytes, 0 if more are needed, -1 if there is
 * none, so that one byte is to be dropped. `head` is filled in as soon as it can be. */
static inline long skinfield_find(const uint8_t *data, size_t size, skinfield_header *head) {
  uint16_t crc;
  size_t whole;
  if (size >= 1 && data[0] != 'S') return -1;
  if (size >= 2 && data[1] != 'F') return -1;
  if (size >= 3 && data[2] != SKINFIELD_VERSION) return -1;
  if (size < sizeof *head) return 0;
  memcpy(head, data, sizeof *head);
  if (head->length > SKINFIELD_LONGEST_PAYLOAD) return -1;
  whole = SKINFIELD_ROOM((size_t)head->length);
  if (size < whole) return 0;
  memcpy(&crc, data + whole - 2, 2);
  return crc == skinfield_crc(data, whole - 2) ? (long)whole : -1;
}

typedef struct { /* what came in of a command; begin with zeros */
  uint8_t data[SKINFIELD_ROOM(4)];
  size_t have;
} skinfield_ear;

/* Hear one byte from the host: the kind of the command that it completes for this device, or 0.
 * `head` is that of the command, `argument` the number behind it, or 0. */
static inline uint8_t skinfield_hear(skinfield_ear *ear, const skinfield_sender *sender,
                                     uint8_t byte, skinfield_header *head, uint32_t *argument) {
  ear->data[ear->have++] = byte;
  while (ear->have) {
    long found = skinfield_find(ear->data, ear->have, head);
    size_t done = found > 0 ? (size_t)found : 1;
    uint8_t kind = 0;
    if (found == 0 && ear->have < sizeof ear->data) return 0;
    if (found > 0 && head->kind >= SKINFIELD_START &&
        (head->device == sender->device || head->device == SKINFIELD_EVERY_DEVICE)) {
      kind = head->kind;
      *argument = 0;
      memcpy(argument, ear->data + sizeof *head, head->length);
    }
    ear->have -= done;
    memmove(ear->data, ear->data + done, ear->have);
    if (kind) return kind;
  }
  return 0;
}

#ifdef __cplusplus
}
#endif

#endif
