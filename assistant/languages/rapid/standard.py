"""Names that RAPID and its options define: no data, routine or module may take them.

Instructions and functions as the reference manual of RobotWare 6 (3HAC050917) lists them,
with those of the welding, spot, force control and gripper options that programs use.
"""

from __future__ import annotations

from typing import Final

INSTRUCTIONS: Final = frozenset(
    """
    AccSet ActEventBuffer ActUnit Add AliasCamera AliasIO AliasIOReset BitClear BitSet
    BookErrNo Break CallByVar CamFlush CamGetParameter CamGetResult CamLoadJob CamReqImage
    CamSetExposure CamSetParameter CamSetProgramMode CamSetRunMode CamStartLoadJob CancelLoad
    CapAPTrSetup CapC CapCondSetDO CapEquiDist CapL CapLATrSetup CapNoProcess CapRefresh
    CapWeaveSync CheckProgRef CirPathMode Clear ClearIOBuff ClearPath ClearRawBytes ClkReset
    ClkStart ClkStop Close CloseDir ConfJ ConfL ContactL CopyFile CopyRawBytes CorrClear
    CorrCon CorrDiscon CorrWrite DeactEventBuffer DeactUnit Decr DropSensor DropWObj
    EGMActJoint EGMActMove EGMActPose EGMGetId EGMMoveC EGMMoveL EGMReset EGMRunJoint
    EGMRunPose EGMSetupAI EGMSetupAO EGMSetupGI EGMSetupLTAPP EGMSetupUC EGMStop EOffsOff
    EOffsOn EOffsSet EraseModule ErrLog ErrRaise ErrWrite ExitCycle FitCircle FricIdEvaluate
    FricIdInit FricIdSetFricLevels GetDataVal GetJointData GetSysData GetTrapData GripLoad
    HollowWristReset ICap IDelete IDisable IEnable IError Incr IndAMove IndCMove IndDMove
    IndReset IndRMove InitSuperv InvertDO IOBusStart IOBusState IODisable IOEnable IPathPos
    IPers IRMQMessage ISignalAI ISignalAO ISignalDI ISignalDO ISignalGI ISignalGO ISleep ITimer
    IVarValue IWatch Load LoadId MakeDir ManLoadIdProc MatrixSolve MatrixSolveQR MatrixSVD
    MechUnitLoad MotionProcessModeSet MotionSup MoveAbsJ MoveC MoveCAO MoveCDO MoveCGO
    MoveCSync MoveExtJ MoveJ MoveJAO MoveJDO MoveJGO MoveJSync MoveL MoveLAO MoveLDO MoveLGO
    MoveLSync MToolRotCalib MToolTCPCalib Open OpenDir PackDNHeader PackRawBytes PathAccLim
    PathRecMoveBwd PathRecMoveFwd PathRecStart PathRecStop PathResol PDispOff PDispOn PDispSet
    ProcerrRecovery PrxActivAndStoreRecord PrxActivRecord PrxDbgStoreRecord PrxDeactRecord
    PrxResetPos PrxResetRecords PrxSetPosOffset PrxSetRecordSampleTime PrxSetSyncalarm
    PrxStartRecord PrxStopRecord PrxStoreRecord PrxUseFileRecord PulseDO RaiseToUser ReadAnyBin
    ReadBlock ReadCfgData ReadErrData ReadRawBytes ReadVarArr RemoveAllCyclicBool
    RemoveCyclicBool RemoveDir RemoveFile RemoveSuperv RenameFile Reset ResetAxisDistance
    ResetAxisMoveTime ResetPPMoved ResetRetryCount RestoPath Rewind RMQEmptyQueue RMQFindSlot
    RMQGetMessage RMQGetMsgData RMQGetMsgHeader RMQReadWait RMQSendMessage RMQSendWait
    SafetyControllerSyncRequest Save SaveCfgData SCWrite SearchC SearchExtJ SearchL SenDevice
    Set SetAllDataVal SetAO SetDataSearch SetDataVal SetDO SetGO SetLeadThrough SetSysData
    SetupCyclicBool SetupSuperv SiClose SiConnect SiGetCyclic SingArea SiSetCyclic SkipWarn
    SocketAccept SocketBind SocketClose SocketConnect SocketCreate SocketListen SocketReceive
    SocketReceiveFrom SocketSend SocketSendTo SoftAct SoftDeact SpeedLimAxis SpeedLimCheckPoint
    SpeedRefresh SpyStart SpyStop StartLoad StartMove StartMoveRetry STCalib STClose
    StepBwdPath STIndGun STIndGunReset SToolRotCalib SToolTCPCalib Stop STOpen StopMove
    StopMoveReset StorePath STTune STTuneReset SupSyncSensorOff SupSyncSensorOn SyncMoveOff
    SyncMoveOn SyncMoveResume SyncMoveSuspend SyncMoveUndo SyncToSensor SystemStopAction
    TestSignDefine TestSignReset TextTabInstall TPErase TPReadDnum TPReadFK TPReadNum TPShow
    TPWrite TriggC TriggCheckIO TriggDataCopy TriggDataReset TriggEquip TriggInt TriggIO TriggJ
    TriggJIOs TriggL TriggLIOs TriggRampAO TriggSpeed TriggStopProc TryInt TuneReset TuneServo
    UIMsgBox UIMsgWrite UIMsgWriteAbort UIShow UnLoad UnpackRawBytes VelSet WaitAI WaitAO
    WaitDI WaitDO WaitGI WaitGO WaitLoad WaitRob WaitSensor WaitSyncTask WaitTestAndSet
    WaitTime WaitUntil WaitWObj WarmStart WorldAccLim Write WriteAnyBin WriteBin WriteBlock
    WriteCfgData WriteRawBytes WriteStrBin WriteVar WriteVarArr WZBoxDef WZCylDef WZDisable
    WZDOSet WZEnable WZFree WZHomeJointDef WZLimJointDef WZLimSup WZSphDef    """.lower().split()
)

FUNCTIONS: Final = frozenset(
    """
    Abs AbsDnum ACos ACosDnum AInput AOutput ArgName ASin ASinDnum ATan ATan2 ATan2Dnum
    ATanDnum BitAnd BitAndDnum BitCheck BitCheckDnum BitLSh BitLShDnum BitNeg BitNegDnum BitOr
    BitOrDnum BitRSh BitRShDnum BitXOr BitXOrDnum ByteToStr CalcJointT CalcRobT CalcRotAxFrameZ
    CalcRotAxisFrame CamGetExposure CamGetLoadedJob CamGetName CamNumberOfResults
    CapGetFailSigs CDate CJointT ClkRead CorrRead Cos CosDnum CPos CRobT CSpeedOverride CTime
    CTool CWObj DecToHex DefAccFrame DefDFrame DefFrame Dim DInput Distance DnumToNum DnumToStr
    DotProd DOutput EGMGetState EulerZYX EventType ExecHandler ExecLevel Exp FileSize
    FileTimeDnum FSSize GetAxisDistance GetAxisMoveTime GetMaxNumberOfCyclicBool GetMecUnitName
    GetModalPayLoadMode GetMotorTorque GetNextCyclicBool GetNextMechUnit GetNextSym
    GetNumberOfCyclicBool GetServiceInfo GetSignalOrigin GetSysInfo GetTaskName GetTime
    GetTSPStatus GInput GInputDnum GOutput GOutputDnum HexToDec IndInpos IndSpeed IOUnitState
    IsBrakeCheckActive IsCyclicBool IsFile IsLeadThrough IsMechUnitActive IsPers IsStopMoveAct
    IsStopStateEvent IsSyncMoveOn IsSysId IsVar MaxRobSpeed MirPos ModExist ModTimeDnum
    MotionPlannerNo NonMotionMode NOrient NumToDnum NumToStr Offs OpMode OrientZYX ORobT
    ParIdPosValid ParIdRobValid PathLevel PathRecValidBwd PathRecValidFwd PFRestart PoseInv
    PoseMult PoseVect Pow PowDnum PPMovedInManMode Present ProgMemFree PrxGetMaxRecordpos
    RawBytesLen ReadBin ReadDir ReadMotor ReadNum ReadStr ReadStrBin ReadVar RelTool
    RemainingRetries RMQGetSlotName RobName RobOS Round RoundDnum RunMode
    SafetyControllerGetChecksum SafetyControllerGetOpModePinCode SafetyControllerGetSWVersion
    SafetyControllerGetUserChecksum Sin SinDnum SocketGetStatus SocketPeek Sqrt SqrtDnum
    STCalcForce STCalcTorque STIsCalib STIsClosed STIsIndGun STIsOpen StrDigCalc StrDigCmp
    StrFind StrLen StrMap StrMatch StrMemb StrOrder StrPart StrToByte StrToVal Tan TanDnum
    TaskIsActive TaskIsExecuting TaskRunMec TaskRunRob TasksInSync TestAndSet TestDI
    TestSignRead TextGet TextTabFreeToUse TextTabGet TriggDataValid Trunc TruncDnum Type
    UIAlphaEntry UIClientExist UIDnumEntry UIDnumTune UIListView UIMessageBox UINumEntry
    UINumTune ValidIO ValToStr VectMagn    """.lower().split()
)

OF_OPTIONS: Final = frozenset(
    """
    ArcC ArcCEnd ArcCStart ArcL ArcLEnd ArcLStart ArcMoveExtJ ArcRefresh ArcRepL BECheckTcp
    BERefPointer BESetupToolJ BEUpdateTcp CalibJ CalibL CornerPathWarning CSSAct CSSDeact
    CSSDeactMoveL DispC DispL EGMStreamStart EGMStreamStop EGMWaitCond ExecEngine FCAct FCCalib
    FCDeact FCPress1LStart FCPressEnd FCPressL g_GripIn g_GripOut g_Init g_JogIn g_JogOut
    g_MoveTo g_SetForce Max MaxExtLinearSpeed MaxExtReorientSpeed MaxRobReorientSpeed Min NutJ
    NutL PaintC PaintL PDispAdd Search_1D SetBrush SetBrushFac SpotJ SpotL    """.lower().split()
)
