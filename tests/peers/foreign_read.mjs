// SPDX-License-Identifier: Apache-2.0
// Reads identity and status with the npm client jsmodbus, written from docs/protocol-modbus.md alone.
//   [NODE_PATH=<folder>/node_modules] node foreign_read.mjs PORT
// The exit code is 1 when a check failed, 77 when jsmodbus is not installed.
import net from 'node:net';
import { createRequire } from 'node:module';

let jsmodbus;
try {
  jsmodbus = createRequire(import.meta.url)('jsmodbus');
} catch {
  console.log('jsmodbus is not installed');
  process.exit(77);
}

function crc16(registers) {
  let crc = 0xffff;
  for (const register of registers) {
    for (const byte of [register >> 8, register & 0xff]) {
      crc ^= byte;
      for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >> 1) ^ 0xa001 : crc >> 1;
    }
  }
  return crc;
}

function check(name, good, detail = '') {
  console.log((good ? 'ok   ' : 'FAIL ') + name + ' ' + detail);
  if (!good) process.exit(1);
}

const socket = new net.Socket();
const client = new jsmodbus.client.TCP(socket, 1, 2000);
await new Promise((resolve) => socket.on('connect', resolve).connect({ host: '127.0.0.1', port: Number(process.argv[2]) }));
const read = async (at, count) => Array.from((await client.readHoldingRegisters(at, count)).response.body.values);

const identity = await read(0, 46);
check('identity', identity[0] === 0x434d && identity[1] === 0x4d31 && identity[2] === 1);
check('identity CRC', crc16(identity.slice(0, 45)) === identity[45]);
// Several at once: the replies come in the order of the requests.
const blocks = await Promise.all(Array.from({ length: 20 }, (_, i) => read(i % 2 ? 64 : 0, i % 2 ? 37 : 46)));
check('pipelined', blocks.every((block, i) => block.length === (i % 2 ? 37 : 46)));
check('status CRC', crc16(blocks[1].slice(0, 36)) === blocks[1][36]);
const fifo = await read(400, 125);
check('FIFO CRC', crc16([...fifo.slice(0, 12), ...fifo.slice(13, 13 + 8 * fifo[7])]) === fifo[12]);
try {
  await read(60000, 1);
  check('exception', false);
} catch (error) {
  check('exception', error.response?.body?.code === 2, String(error.response?.body?.code));
}
process.exit(0);
