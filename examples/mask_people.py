"""Masks without people, for `fsel poses --mask-by`; MediaPipe 0.10.14's package has its weights.

    python -m venv people && people/bin/pip install mediapipe==0.10.14
    fsel poses PHOTOS --mask-by "$PWD/people/bin/python $PWD/examples/mask_people.py" -o posed

Reads `images` and writes `masks`, white but for a person, one an image.
"""

from pathlib import Path

import cv2
import mediapipe
import numpy as np

MARGIN = 0.02  # of the longer side, around a person: its shadow and blur

pose = mediapipe.solutions.pose.Pose(static_image_mode=True, enable_segmentation=True)
for file in sorted(Path("images").iterdir()):
    image = cv2.imread(str(file))
    share = pose.process(cv2.cvtColor(image, cv2.COLOR_BGR2RGB)).segmentation_mask
    person = np.zeros(image.shape[:2], bool) if share is None else share > 0.5
    reach = 2 * round(MARGIN * max(image.shape)) + 1
    grown = cv2.dilate(person.astype(np.uint8), np.ones((reach, reach)))
    cv2.imwrite(str(Path("masks", file.stem + ".png")), 255 - 255 * grown)
