"""Resolution of a layout before it is made: blind spots, detectable force, accuracy."""

from skinfield.resolution.design import Places as Places
from skinfield.resolution.design import SkinDesign as SkinDesign
from skinfield.resolution.design import Touch as Touch
from skinfield.resolution.detectability import BlindSpots as BlindSpots
from skinfield.resolution.detectability import DetectableForce as DetectableForce
from skinfield.resolution.detectability import Hole as Hole
from skinfield.resolution.detectability import blind_spots as blind_spots
from skinfield.resolution.detectability import detectable_force as detectable_force
from skinfield.resolution.discrimination import PlaceAccuracy as PlaceAccuracy
from skinfield.resolution.discrimination import TwoPointDistance as TwoPointDistance
from skinfield.resolution.discrimination import few_places as few_places
from skinfield.resolution.discrimination import place_accuracy as place_accuracy
from skinfield.resolution.discrimination import two_point_distance as two_point_distance
from skinfield.resolution.judgement import Judgement as Judgement
from skinfield.resolution.judgement import Terms as Terms
from skinfield.resolution.judgement import ThicknessComparison as ThicknessComparison
from skinfield.resolution.judgement import compare_thickness as compare_thickness
from skinfield.resolution.judgement import judge as judge
