// SPDX-License-Identifier: Apache-2.0
import {paintGround} from './ground_patterns';

const patterns = paintGround();
(self as unknown as Worker).postMessage(patterns, [patterns.data.buffer]);
