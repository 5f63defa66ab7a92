"""Results for people: the video, the motion file and one HTML page that explains every choice.

`video`, `motion_file` and `html` are the public modules; the others are the page's parts. The page is made
from the run folder's files alone, so a report can be made again at any time.
"""
